//! The tree file, version 1: bytes <-> the world-aligned tree with its space, regions and settings.
//! `spec/adumbra-tree.md` describes it for readers in other languages. Source of the tree: the paper named in
//! [`crate::tree`], §3.3.
//!
//! | part | bytes | meaning |
//! |---|---|---|
//! | header | 320 | magic, version, space, sun, settings, section table, checksum (`header.rs`) |
//! | regions | 40 a region | how deep the tree goes where |
//! | body | 4 a word, or a stream | the tree |
//! | attribute | 1 a leaf voxel, or none | a value beside the visibility |
//!
//! Laid out as the light-aligned file is, see [`mod@crate::format`]: little-endian, sections at multiples of 16, zeros
//! in the gaps, a CRC-32 each, one file for given contents.

mod body;
mod header;
mod read;
mod write;

pub use body::TreeBody;
pub use header::{TREE_HEADER_BYTES, TREE_MAGIC, TREE_VERSION};

pub(super) use header::Header;

use crate::light::Sun;
use crate::tree::{Regions, TreeSettings, TreeSpace};

/// Everything that a tree file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeFile {
    /// Where the tree lies in the world.
    pub space: TreeSpace,
    /// The sun that casts.
    pub sun: Sun,
    /// What the tree was asked for.
    pub settings: TreeSettings,
    /// How deep it goes where; the deepest part is as deep as the space.
    pub regions: Regions,
    /// The voxels.
    pub body: TreeBody,
    /// One byte a leaf voxel, in the order of a walk: children 0 to 7 of every node, however often it is met, and of
    /// each leaf of eight its voxels 0 to 7. [`crate::tree::leaf_voxels`] many; empty = no attribute.
    pub attribute: Vec<u8>,
    /// What the bytes mean; `None` where there are none.
    pub attribute_kind: Option<AttributeKind>,
}

/// What a byte a leaf voxel means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum AttributeKind {
    /// How wide the penumbra is there.
    Penumbra,
}
