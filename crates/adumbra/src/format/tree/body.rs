//! What a tree file's body holds, by its code in the header.

use crate::format::FormatError;
use crate::format::fields::field;
use crate::format::sections::{bounds, u32_words};
use crate::tree::{MAX_DEPTH, VoxelTree};

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
    Symmetric(SymmetricBody),
}

/// What stands for a symmetric tree here, in one place.
pub type SymmetricBody = SymmetricBytes;

/// The stream of a symmetric body, as it is: what is in it is not looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SymmetricBytes {
    depth: u32,
    bytes: Vec<u8>,
}

impl SymmetricBytes {
    /// Takes the stream of a tree of `depth` levels.
    ///
    /// # Errors
    /// A depth that no tree has; an empty stream.
    pub fn from_bytes(depth: u32, bytes: Vec<u8>) -> Result<Self, FormatError> {
        if !(1..=MAX_DEPTH).contains(&depth) {
            return Err(field("depth", depth.to_string(), format!("from 1 to {MAX_DEPTH}")));
        }
        if bytes.is_empty() {
            return Err(bounds("body", "length", 0, "at least 1"));
        }
        Ok(Self { depth, bytes })
    }

    /// Levels below the root.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// The stream.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
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
            Self::Symmetric(SymmetricBody::from_bytes(depth, section.to_vec())?)
        })
    }
}
