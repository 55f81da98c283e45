//! The layouts of a graph: their numbers in the header, and the elements of their sections.

use crate::dag::packed::{MAX_SHARED_LEAF_MASKS, MAX_UNITS};
use crate::dag::plain::SHADOWED;

/// The layout of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DagLayout {
    /// 32-bit headers and pointers, see [`Dag`](crate::dag::plain::Dag).
    Plain,
    /// Units of 16 bits, in about a third of the bytes, see [`PackedDag`](crate::dag::packed::PackedDag).
    Packed,
}

impl DagLayout {
    /// Returns `plain` or `packed`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Packed => "packed",
        }
    }

    /// Returns the layout's number in the header.
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Plain => 0,
            Self::Packed => 1,
        }
    }

    pub(super) fn from_number(number: u32) -> Option<Self> {
        [Self::Plain, Self::Packed].into_iter().find(|layout| layout.number() == number)
    }

    /// Returns the size of an element of each section and the largest size of the section, in bytes. The
    /// length of the top grid is checked elsewhere.
    pub(super) fn elements(self) -> [(u64, u64); 3] {
        let top = (4, u64::MAX);
        match self {
            Self::Plain => [top, (4, 4 * SHADOWED as u64), (8, 8 << 32)],
            Self::Packed => [top, (4, 2 * MAX_UNITS as u64), (8, 8 * MAX_SHARED_LEAF_MASKS as u64)],
        }
    }
}
