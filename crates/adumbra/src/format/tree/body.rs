//! What a tree file's body holds, by its code in the header.

use crate::format::FormatError;
use crate::format::sections::u32_words;
use crate::tree::VoxelTree;
use crate::tree::symmetric::SymmetricTree;

/// Code of a body of words.
pub(super) const WORDS: u32 = 1;
/// Code of a symmetric body.
pub(super) const SYMMETRIC: u32 = 2;

/// The voxels of a tree file.
#[derive(Clone, Debug, PartialEq)]
pub enum TreeBody {
    /// 32-bit words, blocks of eight siblings.
    Words(VoxelTree),
    /// A stream of bytes that also merges mirrored subtrees.
    Symmetric(SymmetricTree),
}

impl TreeBody {
    /// Levels below the root.
    pub fn depth(&self) -> u32 {
        match self {
            Self::Words(tree) => tree.depth(),
            Self::Symmetric(tree) => tree.depth(),
        }
    }

    /// Bytes of the section.
    pub fn bytes_len(&self) -> u64 {
        match self {
            Self::Words(tree) => tree.bytes(),
            Self::Symmetric(tree) => tree.bytes().len() as u64,
        }
    }

    pub(super) fn code(&self) -> u32 {
        match self {
            Self::Words(_) => WORDS,
            Self::Symmetric(_) => SYMMETRIC,
        }
    }

    /// The body of a section with this code, which the header's check has found to be one of the two.
    pub(super) fn read(code: u32, depth: u32, section: &[u8]) -> Result<Self, FormatError> {
        Ok(if code == WORDS {
            Self::Words(VoxelTree::from_words(depth, u32_words(section))?)
        } else {
            Self::Symmetric(SymmetricTree::from_bytes(depth, section.to_vec())?)
        })
    }
}
