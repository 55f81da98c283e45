//! A node as a 32-bit word. Source: the paper's §3.3.1. Its 31 index bits and two flags do not fit into 32
//! bits, so here the flags of a leaf take the place of an index.
//!
//! | bits | inner node | uniform leaf | leaf of eight voxels |
//! |---|---|---|---|
//! | 31 | 0 | 1 | 1 |
//! | 30 | index | 0 | 1 |
//! | 29..8 | index | 0 | 0 |
//! | 7..0 | index | bit 0 = visibility | bit i = visibility of child i |
//!
//! Worked values: `0x0000_0009`: children in words 9 to 16; `0x8000_0001`: lit;
//! `0x8000_0000`: shadowed; `0xc000_00f0`: the children with x bit 1 are lit.

/// Maximum number of levels of a tree.
pub const MAX_DEPTH: u32 = 15;

/// A node as stored in the block of eight of its parent.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Word(pub u32);

const LEAF: u32 = 1 << 31;
const MASK: u32 = 1 << 30;

/// A decoded word.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Node {
    /// The index of child 0; child i is the word at this index plus i.
    Inner(u32),
    /// Every voxel of the node has this visibility.
    Uniform(bool),
    /// A leaf of eight: all voxels of child i have the visibility of bit i. Neither 0 nor 255.
    Mask(u8),
}

impl Word {
    /// Every voxel is lit.
    pub const LIT: Self = Self(LEAF | 1);
    /// Every voxel is shadowed.
    pub const SHADOWED: Self = Self(LEAF);

    /// Encodes a node.
    pub const fn new(node: Node) -> Self {
        match node {
            Node::Inner(index) => Self(index & !LEAF),
            Node::Uniform(lit) => Self(LEAF | lit as u32),
            Node::Mask(mask) => Self(LEAF | MASK | mask as u32),
        }
    }

    /// Returns a leaf of eight voxels, or a uniform leaf if all bits are equal.
    pub const fn leaf(mask: u8) -> Self {
        match mask {
            0 => Self::SHADOWED,
            255 => Self::LIT,
            mixed => Self::new(Node::Mask(mixed)),
        }
    }

    /// Decodes the word. Bits that a leaf does not use are ignored here; [`Word::is_valid`] checks them.
    pub const fn node(self) -> Node {
        if self.0 & LEAF == 0 {
            Node::Inner(self.0)
        } else if self.0 & MASK == 0 {
            Node::Uniform(self.0 & 1 == 1)
        } else {
            Node::Mask(self.0 as u8)
        }
    }

    /// Returns the index of an inner node, or `None` for a leaf.
    pub const fn inner(self) -> Option<u32> {
        match self.node() {
            Node::Inner(index) => Some(index),
            Node::Uniform(_) | Node::Mask(_) => None,
        }
    }

    /// Returns an inner node with its index mapped by `index`; a leaf is unchanged.
    #[must_use]
    pub(crate) fn map_inner(self, index: impl FnOnce(u32) -> u32) -> Self {
        self.inner().map_or(self, |old| Self::new(Node::Inner(index(old))))
    }

    /// Whether the word is one that [`Word::new`] produces and, for a mask, one that [`Word::leaf`] does not
    /// turn into a uniform leaf.
    pub const fn is_valid(self) -> bool {
        match self.node() {
            Node::Inner(_) => true,
            Node::Uniform(lit) => self.0 == Self::new(Node::Uniform(lit)).0,
            Node::Mask(mask) => self.0 == LEAF | MASK | mask as u32 && mask != 0 && mask != 255,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn word_worked_values() {
        assert_eq!(Word::new(Node::Inner(9)).0, 0x0000_0009);
        assert_eq!(Word::LIT.0, 0x8000_0001);
        assert_eq!(Word::SHADOWED.0, 0x8000_0000);
        assert_eq!(Word::leaf(0xf0).0, 0xc000_00f0);
        assert_eq!(Word::leaf(0), Word::SHADOWED);
        assert_eq!(Word::leaf(255), Word::LIT);
        for word in [Word(9), Word::LIT, Word::SHADOWED, Word::leaf(0xf0)] {
            assert_eq!(Word::new(word.node()), word);
            assert!(word.is_valid());
        }
        assert_eq!(Word(9).inner(), Some(9));
        assert_eq!(Word(9).map_inner(|index| index + 8), Word(17));
        for leaf in [Word::LIT, Word::SHADOWED, Word::leaf(0xf0)] {
            assert_eq!((leaf.inner(), leaf.map_inner(|_| 1)), (None, leaf));
        }
        for word in [0x8000_0002, 0xc000_0000, 0xc000_00ff, 0xc000_0101, 0xa000_0001] {
            assert!(!Word(word).is_valid(), "{word:08x}");
        }
    }
}
