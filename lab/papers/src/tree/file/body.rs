//! The body of a tree file, by its code in the header.

use crate::tree::error::TreeFileError;
use crate::tree::graph::VoxelTree;
use crate::tree::symmetric::SymmetricTree;
use adumbra::file::sections::u32_words;

/// Code of a body of words.
pub(crate) const WORDS: u32 = 1;
/// Code of a symmetric body.
pub(crate) const SYMMETRIC: u32 = 2;

/// The voxels of a tree file.
#[derive(Clone, Debug, PartialEq)]
pub enum TreeBody {
    /// 32-bit words, blocks of eight siblings.
    Words(VoxelTree),
    /// A byte stream that also merges mirrored subtrees.
    Symmetric(SymmetricTree),
}

impl TreeBody {
    /// Number of levels below the root.
    pub fn depth(&self) -> u32 {
        match self {
            Self::Words(tree) => tree.depth(),
            Self::Symmetric(tree) => tree.depth(),
        }
    }

    /// Size of the section in bytes.
    pub(crate) fn bytes_len(&self) -> u64 {
        match self {
            Self::Words(tree) => tree.bytes(),
            Self::Symmetric(tree) => tree.bytes().len() as u64,
        }
    }

    pub(crate) fn code(&self) -> u32 {
        match self {
            Self::Words(_) => WORDS,
            Self::Symmetric(_) => SYMMETRIC,
        }
    }

    /// Decodes the body of a section with this code. The header check has already established that it is one
    /// of the two codes.
    pub(crate) fn read(code: u32, depth: u32, section: &[u8]) -> Result<Self, TreeFileError> {
        Ok(if code == WORDS {
            Self::Words(VoxelTree::from_words(depth, u32_words(section))?)
        } else {
            Self::Symmetric(SymmetricTree::from_bytes(depth, section.to_vec())?)
        })
    }
}
