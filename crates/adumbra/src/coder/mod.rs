//! A lossless coder of common sections and bundles, for files that are stored coded.
//!
//! A part is coded as the sequence of its shapes, from the roots down. Each value is predicted from earlier
//! ones: from the depths and ranks that face a shape from above and from the left, and from counts of the
//! earlier values in the same context. Addresses and the forms of pointers are not coded, because they follow
//! from the shapes: a decoder writes them with the same [`Writer`](crate::layout::depths::write::Writer) as a
//! bake. `spec/adumbra-file.md` describes every step for decoders in other languages.
//!
//! Each part is coded alone. A bundle needs the decoded common section, so bundles can be decoded in
//! parallel.
//!
//! Sources: Jarek Duda, *Asymmetric numeral systems* (2009) and *Asymmetric numeral systems: entropy coding
//! combining speed of Huffman coding with compression rate of arithmetic coding* (2013), for the range
//! variant, rANS; Fabian Giesen, *Interleaved entropy coders* (2014), for interleaved states. Probabilities
//! adapt by a shift, as in LZMA.
//!
//! | file | contents |
//! |---|---|
//! | `rans.rs` | bits and symbols to and from bytes |
//! | `model.rs` | all adaptive probabilities, and numbers and depths |
//! | `part.rs` | a common section or a bundle as a whole |
//! | `shapes.rs` | the shapes of a part from and to half-words |
//! | `walk.rs` | the order of shapes; nodes and references |
//! | `leaf.rs`, `columns.rs` | leaves: head, slant and differences; ranks |
//! | `contour.rs` | leaves as numbers, and the outlines that predict their neighbours |
//! | `edges.rs` | depths along the border of the coded area |

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

/// Largest ratio of the bytes of a part's shapes to its coded bytes. An encoder pads a part that compresses
/// better with zeros, so that a file's length bounds the memory that a reader needs.
///
/// Parts of scenes have ratios from 1.5 to 6. Without the padding, a part of equal slopes could reach 2,500.
pub(crate) const LARGEST_RATIO: u64 = 16;

/// Most memory that decoding and then checking a part takes in addition to its words, as a multiple of them.
/// The smallest leaf has four bytes, and takes 60 in lists of shapes that may be half empty. The smallest
/// node has six bytes, and takes 80 in the table of checked shapes.
pub(crate) const DECODING_RATIO: u64 = 16;

/// Returns the least number of coded bytes of a part whose shapes have `words` words. It is even.
pub(crate) fn least_bytes(words: usize) -> usize {
    2 * words.div_ceil(LARGEST_RATIO as usize / 2)
}

/// The encoder got words that a decoder would not restore, or the decoder got bytes that no encoder writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fault;

#[cfg(test)]
mod tests;
