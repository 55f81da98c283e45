//! A lossless coder of common sections and bundles, for files that are stored coded.
//!
//! A part is coded as the sequence of its shapes, from the roots down. What was coded before predicts what comes next:
//! the depths and ranks that face a shape from above and from the left, and counts of what came before in the same
//! context. Addresses and the forms of pointers are not coded, because they follow from the shapes: a decoder writes
//! them with the same [`Writer`](crate::layout::depths::write::Writer) as a bake. `spec/adumbra-file.md` describes
//! every step for decoders in other languages.
//!
//! Each part is coded alone. A bundle needs the decoded common section, so bundles can be decoded in parallel.
//!
//! Sources: Jarek Duda, *Asymmetric numeral systems* (2009) and *Asymmetric numeral systems: entropy coding combining
//! speed of Huffman coding with compression rate of arithmetic coding* (2013), for the range variant, rANS; Fabian
//! Giesen, *Interleaved entropy coders* (2014), for states that take turns. Probabilities adapt by a shift, as in LZMA.
//!
//! | file | contents |
//! |---|---|
//! | `rans.rs` | bits and symbols to and from bytes |
//! | `model.rs` | all adaptive probabilities, and numbers and depths |
//! | `part.rs` | a common section or a bundle as a whole |
//! | `shapes.rs` | lists of shapes, and their half-words |
//! | `walk.rs` | the order of shapes; nodes and references |
//! | `leaf.rs`, `columns.rs` | leaves: head, slant and differences; ranks |
//! | `contour.rs` | leaves as numbers, and what their neighbours see |
//! | `edges.rs` | depths along the border of what was coded |

mod columns;
mod contour;
mod edges;
mod leaf;
mod model;
mod part;
mod rans;
mod shapes;
mod walk;

pub(crate) use part::{decode_bundle, decode_common, encode_bundle, encode_common};
pub(crate) use shapes::Common;

/// Largest ratio of the bytes of a part's shapes to its coded bytes. Zeros follow those of a part that has more, so
/// that a reader knows from a file's length what it takes in memory.
///
/// The parts of scenes have from 1.5 to 6. Without zeros a part of equal slopes could have 2,500.
pub(crate) const LARGEST_RATIO: u64 = 16;

/// What decoding a part, and then checking it, takes at most beside its words, as a multiple of them. The smallest leaf
/// has four bytes, and 60 in lists of shapes that may be half empty. The smallest node has six bytes, and 80 in the
/// table of what has been checked.
pub(crate) const DECODING_RATIO: u64 = 16;

/// Returns the least number of coded bytes of a part with so many words of shapes. It is even.
pub(crate) fn least_bytes(words: usize) -> usize {
    2 * words.div_ceil(LARGEST_RATIO as usize / 2)
}

/// An encoder was given words that a decoder would not restore, or a decoder bytes that no encoder wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fault;

#[cfg(test)]
mod tests;
