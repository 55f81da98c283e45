//! Validates a quadtree from an untrusted source: every shape is within the code, every pointer leads to an earlier
//! shape of the required level, and every column of a leaf has one of its depths.
//!
//! The levels at which an address has been validated are remembered, so the walk takes time linear in the half-words.
//! Whether equal shapes were merged and whether all half-words are in use is not checked, since that affects the size
//! and not the results.

use crate::layout::depths::code::{Child, Code, LeafHead};
use crate::layout::depths::{DepthTree, LEAF_LEVEL, NODE_LEVELS, UNIFORM};

/// A structural fault of a quadtree of depths.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthsError {
    /// The root level is not one of those that a quadtree can have.
    #[error("root level {root_level} is not 5, 7 or 9")]
    RootLevel {
        /// The root level found.
        root_level: u32,
    },
    /// The number of roots does not match the size and the root level.
    #[error("{found} roots in rows of {row}, but the size and the root level require {expected:?}")]
    Roots {
        /// Number of roots found.
        found: usize,
        /// Number of roots per row according to the quadtree.
        row: u32,
        /// Number of roots along x and y that follows from the size.
        expected: [u32; 2],
    },
    /// There are more words of code than addresses can address.
    #[error("{words} words of code, but addresses can reach at most {limit}")]
    TooLong {
        /// The number of words found.
        words: usize,
        /// The largest allowed number.
        limit: usize,
    },
    /// A pointer does not lead to a place before the shape that contains it.
    #[error("the shape at half-word {from} points to {to}, which is not before it")]
    Order {
        /// Address of the shape, or the end of the code for a root.
        from: u32,
        /// The pointer.
        to: u32,
    },
    /// A shape extends past the end of the code.
    #[error("the shape of level {level} at half-word {at} extends past the end of the code")]
    End {
        /// Address of the shape.
        at: u32,
        /// Level of the shape.
        level: u32,
    },
    /// A node refers to an entry of `wide` that does not exist.
    #[error("the node at half-word {at} refers to wide entry {index}, but there are only {count}")]
    Wide {
        /// Address of the node.
        at: u32,
        /// Index of the entry.
        index: u32,
        /// Number of entries.
        count: usize,
    },
    /// Bits are invalid, or a leaf has a single depth and is not slanted.
    #[error("the shape of level {level} at half-word {at} has invalid bits: {half:#06x}")]
    Bits {
        /// Address of the shape.
        at: u32,
        /// Level of the shape.
        level: u32,
        /// The half-word with the bits.
        half: u32,
    },
    /// A column of a leaf has a rank above the last one.
    #[error("the leaf at half-word {at} gives column {column} a rank above its last, {last}")]
    Ranks {
        /// Address of the leaf.
        at: u32,
        /// The column, y · 8 + x.
        column: u32,
        /// Last rank of the leaf.
        last: u32,
    },
}

impl DepthsError {
    /// Returns the variant's name. It is stable across versions and is used by the test vectors.
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

impl DepthTree {
    /// Checks that every look-up in the quadtree terminates with a valid result.
    ///
    /// Cost: one pass over all shapes, and one byte of memory per half-word.
    ///
    /// # Errors
    /// Returns the first fault of a traversal from the roots down.
    pub fn validate(&self) -> Result<(), DepthsError> {
        let root_level = self.root_level;
        if ![5, 7, 9].contains(&root_level) {
            return Err(DepthsError::RootLevel { root_level });
        }
        let expected = [self.size[0], self.size[1]].map(|n| n.div_ceil(1 << root_level));
        let roots = u64::from(expected[0]) * u64::from(expected[1]);
        if self.top_dims != expected || self.top.len() as u64 != roots {
            return Err(DepthsError::Roots { found: self.top.len(), row: self.top_dims[0], expected });
        }
        let limit = (u32::MAX / 2) as usize;
        if self.code.len() > limit {
            return Err(DepthsError::TooLong { words: self.code.len(), limit });
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
    /// Number of half-words.
    end: u32,
    /// For each address, the levels at which it has been validated, one bit per level.
    proved: Vec<u8>,
}

impl Walk<'_> {
    fn pointer(&mut self, from: u32, to: u32, level: u32) -> Result<(), DepthsError> {
        if to >= from {
            return Err(DepthsError::Order { from, to });
        }
        let bit = 1 << ((level - LEAF_LEVEL) / NODE_LEVELS);
        if self.proved[to as usize] & bit == 0 {
            if level == LEAF_LEVEL { self.leaf(to) } else { self.node(to, level) }?;
            self.proved[to as usize] |= bit;
        }
        Ok(())
    }

    fn ends_within(&self, at: u32, length: u32, level: u32) -> Result<(), DepthsError> {
        if length > self.end - at { Err(DepthsError::End { at, level }) } else { Ok(()) }
    }

    fn leaf(&self, at: u32) -> Result<(), DepthsError> {
        let half = self.code.half(at);
        let head = LeafHead::new(half);
        if half >> 10 != 0 || head.width > 2 || (head.last == 0 && (head.never || !head.slanted)) {
            return Err(DepthsError::Bits { at, level: LEAF_LEVEL, half });
        }
        self.ends_within(at, head.length(), LEAF_LEVEL)?;
        let leaf = self.code.leaf(at, 0);
        if let Some(half) = leaf.padding().filter(|half| half >> 8 != 0) {
            return Err(DepthsError::Bits { at, level: LEAF_LEVEL, half });
        }
        match leaf.without_depth() {
            0 => Ok(()),
            columns => Err(DepthsError::Ranks { at, column: columns.trailing_zeros(), last: head.last }),
        }
    }

    fn node(&mut self, at: u32, level: u32) -> Result<(), DepthsError> {
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
                    return Err(DepthsError::Wide { at, index, count });
                }
                if zero != 0 {
                    return Err(DepthsError::Bits { at, level, half: zero });
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
