//! The tree file, version 1: bytes <-> the world-aligned tree with its space, regions and settings.
//! `spec/adumbra-tree.md` describes it for readers in other languages. Source of the tree: the paper named in
//! [`crate`], §3.3.
//!
//! | part | bytes | meaning |
//! |---|---|---|
//! | header | 320 | magic, version, space, sun, settings, section table, checksum (`header.rs`) |
//! | regions | 40 per region | the depth of the tree in each part of the plan |
//! | body | 4 per word, or a stream | the tree |
//! | attribute | 1 per leaf voxel, or none | a value besides the visibility |
//!
//! The structure is that of the light-aligned file, see [`mod@adumbra::file`]: little-endian, sections at
//! multiples of 16, zeros in the gaps, one CRC-32 per section, exactly one file for given contents.

mod body;
mod header;
mod read;
mod words;
mod write;

pub use body::TreeBody;
pub use header::{TREE_HEADER_BYTES, TREE_MAGIC, TREE_VERSION};
pub use words::{file_of_words, words_of};

use crate::tree::bake::BakedTree;
use crate::tree::settings::TreeSettings;
use crate::tree::space::{Regions, TreeSpace};
use adumbra::grid::Sun;

/// The contents of a tree file.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeFile {
    /// The cube of the tree in the world.
    pub space: TreeSpace,
    /// The sun that casts the shadows.
    pub sun: Sun,
    /// The settings of the bake.
    pub settings: TreeSettings,
    /// The depth of the tree in each part of the plan; the deepest part has the depth of the space.
    pub regions: Regions,
    /// The voxels.
    pub body: TreeBody,
    /// One byte per leaf voxel, in the order of a depth-first walk that visits children 0 to 7 of every
    /// occurrence of a node, and voxels 0 to 7 of each leaf of eight. The length is
    /// [`crate::tree::leaf_voxels`]; empty = no attribute.
    pub attribute: Vec<u8>,
    /// The meaning of the attribute bytes; `None` if there are none.
    pub attribute_kind: Option<AttributeKind>,
}

impl TreeFile {
    /// The sun that the file was baked for.
    pub fn sun(&self) -> Sun {
        self.sun
    }

    /// Whether the bake treated masked materials as opaque.
    pub fn ignores_alpha(&self) -> bool {
        self.settings.ignore_alpha
    }
}

impl From<BakedTree> for TreeFile {
    /// Makes the file of a baked tree, as words and without an attribute.
    fn from(baked: BakedTree) -> Self {
        let BakedTree { space, regions, settings, sun, tree, .. } = baked;
        let body = TreeBody::Words(tree);
        Self { space, sun, settings, regions, body, attribute: Vec::new(), attribute_kind: None }
    }
}

/// The meaning of the byte per leaf voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum AttributeKind {
    /// The width of the penumbra at the voxel.
    Penumbra,
}
