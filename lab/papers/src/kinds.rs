//! The kinds of file of this crate, by their first bytes.

use adumbra::FormatError;
use adumbra::file::fields::{self, Decoder, Kind};

/// A file with a graph of the 2014 paper. The line break reveals files that were copied in text mode.
pub(crate) const GRAPH: Kind =
    Kind { magic: *b"ADUMDAG\n", shown: "\"ADUMDAG\\n\"", name: "graph file", version: 1 };
/// A file with a world-aligned tree.
pub(crate) const TREE: Kind =
    Kind { magic: *b"ADUMTREE", shown: "\"ADUMTREE\"", name: "tree file", version: 1 };

/// Checks the header of a file, as [`fields::identify`] does, and names a file of the other kind.
///
/// # Errors
/// Returns the fault with the values found.
pub(crate) fn identify<'a, const N: usize>(bytes: &'a [u8], kind: &Kind) -> Result<Decoder<'a>, FormatError> {
    match [GRAPH, TREE].iter().find(|other| other.magic != kind.magic && bytes.starts_with(&other.magic)) {
        Some(other) => Err(FormatError::OtherKind { found: other.name, needed: kind.name }),
        None => fields::identify::<N>(bytes, kind),
    }
}
