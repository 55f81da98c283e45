//! Proves that words from anywhere can be looked up in: every shape lies within the code, every pointer leads to one before it that
//! is a shape of the level asked for, and every column of a leaf has one of its depths.
//!
//! What is proved of an address at a level is remembered, so the walk takes time linear in the half-words. Whether equal shapes were merged,
//! and whether all half-words are in use, is not checked: that decides the size, not the answers.

use super::code::{Child, Code, LeafHead};
use super::{Hierarchy, LEAF_LEVEL, NODE_LEVELS, UNIFORM};

/// A structural fault of a hierarchy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HierarchyError {
    /// The root level is none that roots can have.
    #[error("root level {root_level} is not 5, 7 or 9")]
    RootLevel {
        /// The level given.
        root_level: u32,
    },
    /// The roots' number does not follow from the size and the root level.
    #[error("{found} roots in rows of {row}, but the size and the root level ask for {expected:?}")]
    Roots {
        /// How many there are.
        found: usize,
        /// How many are said to be in a row.
        row: u32,
        /// What follows from the size.
        expected: [u32; 2],
    },
    /// More words than addresses can name.
    #[error("{words} words of code, but addresses name at most {limit}")]
    TooLong {
        /// How many there are.
        words: usize,
        /// The most there may be.
        limit: usize,
    },
    /// A pointer that does not lead to before the shape that it stands in.
    #[error("the shape at half-word {from} points to {to}, which is not before it")]
    Order {
        /// The shape's address, or the end of the code for a root.
        from: u32,
        /// The pointer.
        to: u32,
    },
    /// A shape that goes on behind the code.
    #[error("the shape of level {level} at half-word {at} ends behind the code")]
    End {
        /// Its address.
        at: u32,
        /// Its level.
        level: u32,
    },
    /// An entry that `wide` does not have.
    #[error("the node at half-word {at} names wide entry {index} of {count}")]
    Wide {
        /// The node's address.
        at: u32,
        /// The entry.
        index: u32,
        /// How many there are.
        count: usize,
    },
    /// Bits that have no meaning, or a leaf of one depth that is not slanted.
    #[error("the shape of level {level} at half-word {at} has bits that mean nothing: {half:#06x}")]
    Bits {
        /// Its address.
        at: u32,
        /// Its level.
        level: u32,
        /// The half-word.
        half: u32,
    },
    /// A column of a leaf has a rank above the last one.
    #[error("the leaf at half-word {at} gives column {column} a rank above its last, {last}")]
    Ranks {
        /// The leaf's address.
        at: u32,
        /// The column, y · 8 + x.
        column: u32,
        /// The leaf's last rank.
        last: u32,
    },
}

impl HierarchyError {
    /// The variant's name, stable across versions; test vectors use it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::RootLevel { .. } => "RootLevel",
            Self::Roots { .. } => "Roots",
            Self::TooLong { .. } => "TooLong",
            Self::Order { .. } => "Order",
            Self::End { .. } => "End",
            Self::Wide { .. } => "Wide",
            Self::Bits { .. } => "Bits",
            Self::Ranks { .. } => "Ranks",
        }
    }
}

impl Hierarchy {
    /// Checks that every look-up ends at an answer; see the module's text.
    ///
    /// Cost: one pass over all shapes, and a byte of memory a half-word.
    ///
    /// # Errors
    /// The first fault met from the roots down.
    pub fn validate(&self) -> Result<(), HierarchyError> {
        let root_level = self.root_level;
        if ![5, 7, 9].contains(&root_level) {
            return Err(HierarchyError::RootLevel { root_level });
        }
        let expected = [self.size[0], self.size[1]].map(|n| n.div_ceil(1 << root_level));
        let roots = u64::from(expected[0]) * u64::from(expected[1]);
        if self.top_dims != expected || self.top.len() as u64 != roots {
            return Err(HierarchyError::Roots { found: self.top.len(), row: self.top_dims[0], expected });
        }
        let limit = (u32::MAX / 2) as usize;
        if self.code.len() > limit {
            return Err(HierarchyError::TooLong { words: self.code.len(), limit });
        }
        let end = 2 * self.code.len() as u32;
        let mut walk = Walk { code: self.shapes(), end, proved: vec![0; end as usize] };
        for &[at, _] in self.top.iter().filter(|entry| entry[0] != UNIFORM) {
            walk.pointer(end, at, root_level)?;
        }
        Ok(())
    }
}

struct Walk<'c> {
    code: Code<'c>,
    /// Half-words there are.
    end: u32,
    /// By address, the levels at which it is known to be a shape, a bit each.
    proved: Vec<u8>,
}

impl Walk<'_> {
    fn pointer(&mut self, from: u32, to: u32, level: u32) -> Result<(), HierarchyError> {
        if to >= from {
            return Err(HierarchyError::Order { from, to });
        }
        let bit = 1 << ((level - LEAF_LEVEL) / NODE_LEVELS);
        if self.proved[to as usize] & bit == 0 {
            if level == LEAF_LEVEL { self.leaf(to) } else { self.node(to, level) }?;
            self.proved[to as usize] |= bit;
        }
        Ok(())
    }

    fn ends_within(&self, at: u32, length: u32, level: u32) -> Result<(), HierarchyError> {
        if length > self.end - at { Err(HierarchyError::End { at, level }) } else { Ok(()) }
    }

    fn leaf(&self, at: u32) -> Result<(), HierarchyError> {
        let half = self.code.half(at);
        let head = LeafHead::new(half);
        if half >> 10 != 0 || head.width > 2 || (head.last == 0 && (head.never || !head.slanted)) {
            return Err(HierarchyError::Bits { at, level: LEAF_LEVEL, half });
        }
        self.ends_within(at, head.length(), LEAF_LEVEL)?;
        let leaf = self.code.leaf(at, 0);
        if let Some(half) = leaf.padding().filter(|half| half >> 8 != 0) {
            return Err(HierarchyError::Bits { at, level: LEAF_LEVEL, half });
        }
        match leaf.without_depth() {
            0 => Ok(()),
            columns => Err(HierarchyError::Ranks { at, column: columns.trailing_zeros(), last: head.last }),
        }
    }

    fn node(&mut self, at: u32, level: u32) -> Result<(), HierarchyError> {
        self.ends_within(at, 3, level)?;
        let [low, high, kind] = [0, 1, 2].map(|h| self.code.half(at + h));
        self.ends_within(at, 3 + low.count_ones() + 2 * high.count_ones(), level)?;
        let mut field = at + 3;
        for c in 0..16 {
            let size = (low >> c & 1) + 2 * (high >> c & 1);
            if size == 3 && kind >> c & 1 == 1 {
                let (index, zero) = (self.code.two_halves(field), self.code.half(field + 2));
                let count = self.code.wide.len();
                if index as usize >= count {
                    return Err(HierarchyError::Wide { at, index, count });
                }
                if zero != 0 {
                    return Err(HierarchyError::Bits { at, level, half: zero });
                }
            }
            if let Child::Shape { at: to, .. } = self.code.child(at, c) {
                self.pointer(at, to, level - NODE_LEVELS)?;
            }
            field += size;
        }
        Ok(())
    }
}
