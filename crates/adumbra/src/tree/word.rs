//! One node as a 32-bit word. Source: the paper's §3.3.1; its 31 index bits and two flags do not fit 32, so the flags
//! of a leaf take the place of an index.
//!
//! | bits | inner node | uniform leaf | leaf of eight voxels |
//! |---|---|---|---|
//! | 31 | 0 | 1 | 1 |
//! | 30 | index | 0 | 1 |
//! | 29..8 | index | 0 | 0 |
//! | 7..0 | index | bit 0 = visibility | bit i = visibility of child i |
//!
//! Worked values: `0x0000_0009` children in words 9 to 16; `0x8000_0001` lit; `0x8000_0000` shadowed; `0xc000_00f0` the
//! children with x bit 1 are lit.

/// A node, as it stands in its parent's block of eight.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct Word(pub u32);

const LEAF: u32 = 1 << 31;
const MASK: u32 = 1 << 30;

/// What a word says.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Node {
    /// Child i is the word at this index plus i.
    Inner(u32),
    /// Every voxel of the node has this visibility.
    Uniform(bool),
    /// Child i, all of it, has the visibility of bit i. Neither 0 nor 255.
    Mask(u8),
}

impl Word {
    /// Every voxel is lit.
    pub const LIT: Self = Self(LEAF | 1);
    /// Every voxel is shadowed.
    pub const SHADOWED: Self = Self(LEAF);

    /// The word of a node.
    pub const fn new(node: Node) -> Self {
        match node {
            Node::Inner(index) => Self(index & !LEAF),
            Node::Uniform(lit) => Self(LEAF | lit as u32),
            Node::Mask(mask) => Self(LEAF | MASK | mask as u32),
        }
    }

    /// A leaf of eight voxels; uniform where they agree.
    pub const fn leaf(mask: u8) -> Self {
        match mask {
            0 => Self::SHADOWED,
            255 => Self::LIT,
            mixed => Self::new(Node::Mask(mixed)),
        }
    }

    /// What the word says. Bits that a leaf does not use are ignored here; [`Word::is_valid`] looks at them.
    pub const fn node(self) -> Node {
        if self.0 & LEAF == 0 {
            Node::Inner(self.0)
        } else if self.0 & MASK == 0 {
            Node::Uniform(self.0 & 1 == 1)
        } else {
            Node::Mask(self.0 as u8)
        }
    }

    /// The index of an inner node; none of a leaf.
    pub const fn inner(self) -> Option<u32> {
        match self.node() {
            Node::Inner(index) => Some(index),
            Node::Uniform(_) | Node::Mask(_) => None,
        }
    }

    /// An inner node with another index; a leaf as it is.
    #[must_use]
    pub fn map_inner(self, index: impl FnOnce(u32) -> u32) -> Self {
        self.inner().map_or(self, |old| Self::new(Node::Inner(index(old))))
    }

    /// Whether the word is one that [`Word::new`] makes and, for a mask, one that [`Word::leaf`] leaves mixed.
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
