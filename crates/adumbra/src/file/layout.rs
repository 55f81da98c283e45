//! The layout of a file's voxels: its number in the header, and the elements of its sections.

use crate::layout::packed::{MAX_SHARED_LEAF_MASKS, MAX_UNITS};
use crate::layout::plain::SHADOWED;

/// The layout of the voxels in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "lowercase"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Layout {
    /// A graph of 32-bit headers and pointers, see [`Dag`](crate::layout::plain::Dag).
    Plain,
    /// The plain layout's graph in units of 16 bits, in about a third of the bytes, see
    /// [`PackedDag`](crate::layout::packed::PackedDag).
    Packed,
    /// A quadtree of switch depths, the smallest layout and the default of bakes, see [`DepthTree`](crate::layout::depths::DepthTree).
    #[default]
    Depths,
}

impl Layout {
    /// Returns `plain`, `packed` or `depths`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Packed => "packed",
            Self::Depths => "depths",
        }
    }

    /// Returns the layout's number in the header.
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Plain => 0,
            Self::Packed => 1,
            Self::Depths => 2,
        }
    }

    pub(super) fn from_number(number: u32) -> Option<Self> {
        [Self::Plain, Self::Packed, Self::Depths].into_iter().find(|layout| layout.number() == number)
    }

    /// Returns the size of an element of each section and the largest size of the section, in bytes. The length of the
    /// top grid is checked elsewhere.
    pub(super) fn elements(self) -> [(u64, u64); 3] {
        let top = (4, u64::MAX);
        match self {
            Self::Plain => [top, (4, 4 * SHADOWED as u64), (8, 8 << 32)],
            Self::Packed => [top, (4, 2 * MAX_UNITS as u64), (8, 8 * MAX_SHARED_LEAF_MASKS as u64)],
            Self::Depths => [top, (4, 2 * u64::from(u32::MAX)), (8, 8 << 32)],
        }
    }
}
