//! Validates a quadtree from an untrusted source: every shape is within its page or the common section, every
//! pointer leads to an earlier shape of the same page or to one of the common section, and every column of a
//! leaf has one of its depths.
//!
//! The walk remembers the levels at which an address has been validated, and refuses shapes that overlap. Its
//! time and memory are therefore linear in the number of half-words. It does not check whether equal shapes
//! were merged and whether all half-words are in use, since that affects the size and not the results.

use std::fmt;

use crate::layout::depths::child::{Child, ShapeRef};
use crate::layout::depths::code::{Code, fields_length};
use crate::layout::depths::leaf::LeafHead;
use crate::layout::depths::page::{IN_PAGE, PAGE_LEVEL, Page};
use crate::layout::depths::{DepthTree, LEAF_LEVEL, NODE_LEVELS, UNIFORM};

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
    /// A pointer leads neither to a place before the shape that contains it, in the same part, nor from a
    /// page to the common section.
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
    /// The shapes that were found have more half-words together than their part, so some overlap, or one is
    /// used at two levels.
    #[error("the shapes of {part} overlap: at half-word {at} they have more half-words than there are")]
    Overlap {
        /// The part.
        part: Part,
        /// Address of the shape that does not fit.
        at: u32,
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
            Self::Overlap { .. } => "Overlap",
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
    let common = tree.common();
    let mut validator = PageValidator::new(common);
    let [across, down] = tree.page_dims;
    let places = (0..down).flat_map(|y| (0..across).map(move |x| [x, y]));
    places.into_iter().try_for_each(|place| validator.page(common, place, &tree.page(place)))
}

/// Validates pages that share a common section.
#[derive(Debug)]
pub struct PageValidator {
    /// [`Walk::proved`] and [`Walk::left`] of the common section.
    common: Vec<u8>,
    common_left: u32,
}

impl PageValidator {
    /// Begins with the words of a common section.
    pub fn new(common: &[u32]) -> Self {
        let halves = 2 * common.len();
        Self { common: vec![0; halves], common_left: halves as u32 }
    }

    /// Checks that every look-up in a page ends with a valid result. `common` is the section that the
    /// validator began with; `place` names the page.
    ///
    /// # Errors
    /// Returns the first fault of a traversal from the root down. The validator must not be used again then,
    /// because it has counted shapes that it has not validated.
    pub fn page(&mut self, common: &[u32], place: [u32; 2], page: &Page<'_>) -> Result<(), DepthsError> {
        debug_assert_eq!(self.common.len(), 2 * common.len(), "another common section");
        let Page { root, words, .. } = *page;
        if root == UNIFORM {
            return Ok(());
        }
        let part = Part::Page(place);
        let unfit = DepthsError::Root { page: part, root };
        let mut common = Walk::new(common, Part::Common, &mut self.common, &mut self.common_left);
        if root & IN_PAGE == 0 {
            if root >= common.end {
                return Err(unfit);
            }
            return common.shape(None, root, PAGE_LEVEL);
        }
        let mut proved = vec![0; 2 * words.len()];
        let mut left = proved.len() as u32;
        let mut walk = Walk::new(words, part, &mut proved, &mut left);
        let at = root & !IN_PAGE;
        if at >= walk.end {
            return Err(unfit);
        }
        walk.shape(Some(&mut common), at, PAGE_LEVEL)
    }
}

/// Walks through a part of the code.
#[derive(Debug)]
struct Walk<'c> {
    code: Code<'c>,
    part: Part,
    /// Number of half-words.
    end: u32,
    /// For each half-word, the levels at which it has been validated, one bit per level.
    proved: &'c mut [u8],
    /// Number of half-words that further shapes may have.
    left: &'c mut u32,
}

impl<'c> Walk<'c> {
    fn new(words: &'c [u32], part: Part, proved: &'c mut [u8], left: &'c mut u32) -> Self {
        Self { code: Code { words }, part, end: 2 * words.len() as u32, proved, left }
    }

    /// Validates the shape at an address within the part. `common` is the common section, or `None` if the
    /// part itself is.
    fn shape(&mut self, common: Option<&mut Walk<'_>>, at: u32, level: u32) -> Result<(), DepthsError> {
        let bit = 1 << ((level - LEAF_LEVEL) / NODE_LEVELS);
        let slot = at as usize;
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
        Err(DepthsError::End { part: self.part, at, level })
    }

    /// Counts the half-words of a shape against the part's.
    fn spend(&mut self, at: u32, length: u32) -> Result<(), DepthsError> {
        let part = self.part;
        *self.left = self.left.checked_sub(length).ok_or(DepthsError::Overlap { part, at })?;
        Ok(())
    }

    fn bits(&self, at: u32, level: u32, half: u32) -> DepthsError {
        DepthsError::Bits { part: self.part, at, level, half }
    }

    fn leaf(&mut self, at: u32) -> Result<(), DepthsError> {
        let half = self.code.half(at);
        let head = LeafHead::new(half);
        if half >> 10 != 0 || head.width > 2 || (head.last == 0 && (head.never || !head.slanted)) {
            return Err(self.bits(at, LEAF_LEVEL, half));
        }
        self.ends_within(at, head.length(), LEAF_LEVEL)?;
        self.spend(at, head.length())?;
        let leaf = self.code.leaf(at, 0);
        if let Some(half) = leaf.padding().filter(|half| half >> 8 != 0) {
            return Err(self.bits(at, LEAF_LEVEL, half));
        }
        match leaf.at_least(head.last + 1) {
            0 => Ok(()),
            columns => Err(DepthsError::Ranks {
                part: self.part,
                at,
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
        let length = 3 + fields_length(low, high, kind, 0xffff);
        self.ends_within(at, length, level)?;
        self.spend(at, length)?;
        for (child, decoded) in (0..).zip(self.code.children(at)) {
            let Child::Shape { shape, .. } = decoded else { continue };
            let (to, below) = (shape.at(), level - NODE_LEVELS);
            match (shape, &mut common) {
                (ShapeRef::Common(_), Some(common)) if to < common.end => common.shape(None, to, below)?,
                (ShapeRef::Common(_), Some(_)) => return Err(self.order(at, child)),
                _ if to >= at => return Err(self.order(at, child)),
                (_, common) => self.shape(common.as_deref_mut(), to, below)?,
            }
        }
        Ok(())
    }

    fn order(&self, at: u32, child: u32) -> DepthsError {
        DepthsError::Order { part: self.part, at, child }
    }
}
