//! Validates a quadtree from an untrusted source: every shape is within its page or the common section, every pointer
//! leads to an earlier shape of the same page or to one of the common section, and every column of a leaf has one of its
//! depths.
//!
//! The levels at which an address has been validated are remembered, so the walk takes time linear in the half-words.
//! Whether equal shapes were merged and whether all half-words are in use is not checked, since that affects the size
//! and not the results.

use std::fmt;

use crate::layout::depths::code::{Child, Code, LeafHead, fields_length};
use crate::layout::depths::page::{IN_PAGE, PAGE_LEVEL};
use crate::layout::depths::{DepthTree, LEAF_LEVEL, NODE_LEVELS, PlacedPage, UNIFORM};

/// A part of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The common section.
    Common,
    /// The page at this place along x and y.
    Page([u32; 2]),
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Common => f.write_str("the common section"),
            Self::Page([x, y]) => write!(f, "page ({x}, {y})"),
        }
    }
}

/// A structural fault of a quadtree of depths. Addresses count half-words from the beginning of their part.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthsError {
    /// There are more words of code than addresses can address.
    #[error("{words} words of code, but addresses can reach at most {limit}")]
    TooLong {
        /// The number of words found.
        words: usize,
        /// The largest allowed number.
        limit: usize,
    },
    /// The root of a page is neither within the page nor within the common section.
    #[error("the root of {page} is {root:#010x}, which is neither in it nor in the common section")]
    Root {
        /// The page.
        page: Part,
        /// The root as it is stored.
        root: u32,
    },
    /// A pointer leads neither to a place before the shape that contains it, in the same part, nor from a page to the
    /// common section.
    #[error(
        "the shape at half-word {at} of {part} has a pointer for child {child} that leads neither to an earlier shape of that part nor to the common section"
    )]
    Order {
        /// The part of the shape.
        part: Part,
        /// Address of the shape.
        at: u32,
        /// The child.
        child: u32,
    },
    /// A shape extends past the end of its part.
    #[error("the shape of level {level} at half-word {at} of {part} extends past its end")]
    End {
        /// The part of the shape.
        part: Part,
        /// Address of the shape.
        at: u32,
        /// Level of the shape.
        level: u32,
    },
    /// Bits are invalid, or a leaf has a single depth and is not slanted.
    #[error("the shape of level {level} at half-word {at} of {part} has invalid bits: {half:#06x}")]
    Bits {
        /// The part of the shape.
        part: Part,
        /// Address of the shape.
        at: u32,
        /// Level of the shape.
        level: u32,
        /// The half-word with the bits.
        half: u32,
    },
    /// A column of a leaf has a rank above the last one.
    #[error("the leaf at half-word {at} of {part} gives column {column} a rank above its last, {last}")]
    Ranks {
        /// The part of the leaf.
        part: Part,
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
            Self::TooLong { .. } => "TooLong",
            Self::Root { .. } => "Root",
            Self::Order { .. } => "Order",
            Self::End { .. } => "End",
            Self::Bits { .. } => "Bits",
            Self::Ranks { .. } => "Ranks",
        }
    }
}

/// Checks that every look-up in the quadtree ends with a valid result.
pub(super) fn validate(tree: &DepthTree) -> Result<(), DepthsError> {
    let limit = (u32::MAX / 2) as usize;
    if tree.code.len() > limit {
        return Err(DepthsError::TooLong { words: tree.code.len(), limit });
    }
    let whole = Code { words: &tree.code };
    let mut common = Walk::new(whole, Part::Common, 0, tree.common_words);
    let mut proved = Vec::new();
    let across = tree.page_dims[0];
    for (i, page) in (0_u32..).zip(&tree.places) {
        let PlacedPage { root, first_word, words, .. } = *page;
        if root == UNIFORM {
            continue;
        }
        let part = Part::Page([i % across, i / across]);
        let unfit = DepthsError::Root { page: part, root };
        if root & IN_PAGE == 0 {
            if root >= common.end {
                return Err(unfit);
            }
            common.shape(None, root, PAGE_LEVEL)?;
            continue;
        }
        let mut walk = Walk::new(whole, part, first_word, words);
        walk.proved = proved;
        walk.proved.clear();
        walk.proved.resize(2 * words, 0);
        let at = walk.start.checked_add(root & !IN_PAGE).filter(|&at| at < walk.end).ok_or(unfit)?;
        walk.shape(Some(&mut common), at, PAGE_LEVEL)?;
        proved = walk.proved;
    }
    Ok(())
}

/// Walks through a part of the code.
struct Walk<'c> {
    /// The whole code.
    code: Code<'c>,
    part: Part,
    /// First half-word of the part, and the one after its last.
    start: u32,
    end: u32,
    /// For each half-word of the part, the levels at which it has been validated, one bit per level.
    proved: Vec<u8>,
}

impl<'c> Walk<'c> {
    fn new(code: Code<'c>, part: Part, first_word: usize, words: usize) -> Self {
        let (start, end) = (2 * first_word as u32, 2 * (first_word + words) as u32);
        let proved = if part == Part::Common { vec![0; 2 * words] } else { Vec::new() };
        Self { code, part, start, end, proved }
    }

    /// Validates the shape at an address within the part. `common` is the common section, unless the part is.
    fn shape(&mut self, common: Option<&mut Walk<'_>>, at: u32, level: u32) -> Result<(), DepthsError> {
        let bit = 1 << ((level - LEAF_LEVEL) / NODE_LEVELS);
        let slot = (at - self.start) as usize;
        if self.proved[slot] & bit == 0 {
            if level == LEAF_LEVEL { self.leaf(at) } else { self.node(common, at, level) }?;
            self.proved[slot] |= bit;
        }
        Ok(())
    }

    fn ends_within(&self, at: u32, length: u32, level: u32) -> Result<(), DepthsError> {
        if length <= self.end - at {
            return Ok(());
        }
        Err(DepthsError::End { part: self.part, at: at - self.start, level })
    }

    fn bits(&self, at: u32, level: u32, half: u32) -> DepthsError {
        DepthsError::Bits { part: self.part, at: at - self.start, level, half }
    }

    fn leaf(&self, at: u32) -> Result<(), DepthsError> {
        let half = self.code.half(at);
        let head = LeafHead::new(half);
        if half >> 10 != 0 || head.width > 2 || (head.last == 0 && (head.never || !head.slanted)) {
            return Err(self.bits(at, LEAF_LEVEL, half));
        }
        self.ends_within(at, head.length(), LEAF_LEVEL)?;
        let leaf = self.code.leaf(at, 0);
        if let Some(half) = leaf.padding().filter(|half| half >> 8 != 0) {
            return Err(self.bits(at, LEAF_LEVEL, half));
        }
        match leaf.without_depth() {
            0 => Ok(()),
            columns => Err(DepthsError::Ranks {
                part: self.part,
                at: at - self.start,
                column: columns.trailing_zeros(),
                last: head.last,
            }),
        }
    }

    fn node(&mut self, mut common: Option<&mut Walk<'_>>, at: u32, level: u32) -> Result<(), DepthsError> {
        self.ends_within(at, 3, level)?;
        let [low, high, kind] = [0, 1, 2].map(|h| self.code.half(at + h));
        if low & high & kind != 0 {
            return Err(self.bits(at, level, kind));
        }
        self.ends_within(at, 3 + fields_length(low, high, kind, 0xffff), level)?;
        for (child, decoded) in (0..).zip(self.code.children(at)) {
            let Child::Shape { at: to, is_relative, .. } = decoded else { continue };
            let below = level - NODE_LEVELS;
            match &mut common {
                Some(common) if !is_relative && to < common.end => common.shape(None, to, below)?,
                Some(_) if !is_relative => return Err(self.order(at, child)),
                _ if to < self.start || to >= at => return Err(self.order(at, child)),
                common => self.shape(common.as_deref_mut(), to, below)?,
            }
        }
        Ok(())
    }

    fn order(&self, at: u32, child: u32) -> DepthsError {
        DepthsError::Order { part: self.part, at: at - self.start, child }
    }
}
