//! The depths at which the columns of a page or bundle switch, as a range. A table of pages holds the ranges,
//! so that code that chooses pages or marches through the depths does not need the pages themselves.

use std::collections::HashMap;
use std::sync::Mutex;

use crate::layout::depths::child::{Child, ShapeRef};
use crate::layout::depths::code::Code;
use crate::layout::depths::page::{IN_PAGE, PAGE_LEVEL, Page};
use crate::layout::depths::{LEAF_LEVEL, NEVER, NODE_LEVELS, UNIFORM};

/// Bounds of the depths at which columns switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    /// No column switches nearer to the sun. [`NEVER`] if none switches.
    pub nearest: u32,
    /// No column that switches does so deeper. [`NEVER`] if none switches.
    pub farthest: u32,
    /// Whether some column never switches.
    pub has_never: bool,
}

impl Range {
    /// The range of columns that never switch.
    pub const NEVER: Self = Self { nearest: NEVER, farthest: NEVER, has_never: true };

    /// Returns the range of columns that switch at `depth`, which may be [`NEVER`].
    pub fn uniform(depth: u32) -> Self {
        Self { nearest: depth, farthest: depth, has_never: depth == NEVER }
    }

    /// Returns the range of both sets of columns.
    #[must_use]
    pub fn joined(self, other: Self) -> Self {
        let farthest = match (self.farthest, other.farthest) {
            (NEVER, farthest) | (farthest, NEVER) => farthest,
            (one, other) => one.max(other),
        };
        let nearest = self.nearest.min(other.nearest);
        Self { nearest, farthest, has_never: self.has_never || other.has_never }
    }
}

/// Bounds relative to a base. They are wide enough for any sum of differences, and are limited to depths at
/// the root.
#[derive(Clone, Copy, Debug)]
struct Relative {
    nearest: i64,
    farthest: i64,
    has_never: bool,
}

impl Relative {
    /// No columns.
    const NONE: Self = Self { nearest: i64::MAX, farthest: i64::MIN, has_never: false };

    fn at(difference: i64) -> Self {
        Self { nearest: difference, farthest: difference, has_never: false }
    }

    fn moved(self, by: i64) -> Self {
        let moved = |c: i64| if self.nearest > self.farthest { c } else { c + by };
        Self { nearest: moved(self.nearest), farthest: moved(self.farthest), ..self }
    }

    fn joined(self, other: Self) -> Self {
        Self {
            nearest: self.nearest.min(other.nearest),
            farthest: self.farthest.max(other.farthest),
            has_never: self.has_never || other.has_never,
        }
    }

    /// Returns the bounds at a base.
    fn at_base(self, base: u32) -> Range {
        if self.nearest > self.farthest {
            return Range::NEVER;
        }
        let depth = |c: i64| (i64::from(base) + c).clamp(0, i64::from(NEVER) - 1) as u32;
        Range { nearest: depth(self.nearest), farthest: depth(self.farthest), has_never: self.has_never }
    }
}

/// Finds the ranges of pages that share a common section.
///
/// A leaf's bounds are those of its planes: its base less the largest rise of its slant, and its base and all
/// of its differences. Differences count with their sign.
pub struct Ranges<'c> {
    common: Code<'c>,
    /// Ranges of nodes of the common section.
    known: Known,
    /// Ranges of nodes of the page that is visited.
    of_page: Known,
}

/// Ranges of a common section, for use by any number of threads.
pub struct SharedRanges<'c> {
    common: &'c [u32],
    idle: Mutex<Vec<Ranges<'c>>>,
}

impl<'c> SharedRanges<'c> {
    /// Begins with the words of a common section. All pages must be valid.
    pub fn new(common: &'c [u32]) -> Self {
        Self { common, idle: Mutex::default() }
    }

    /// Calls `work` with ranges that no other thread uses.
    pub fn with<T>(&self, work: impl FnOnce(&mut Ranges<'c>) -> T) -> T {
        let idle = || self.idle.lock().unwrap_or_else(|e| e.into_inner());
        let known = idle().pop();
        let mut ranges = known.unwrap_or_else(|| Ranges::new(self.common));
        let made = work(&mut ranges);
        idle().push(ranges);
        made
    }
}

/// Ranges of nodes by address and level.
#[derive(Default)]
struct Known {
    /// For each half-word, one more than the index of the node that begins there.
    places: Vec<u32>,
    list: Vec<(u32, Relative)>,
    /// Nodes that are reached at a second level. Only forged pages have such nodes.
    others: HashMap<(u32, u32), Relative>,
}

impl Known {
    /// Clears everything, and makes room for the nodes of `words` words.
    fn begin(&mut self, words: usize) {
        self.places.clear();
        self.places.resize(2 * words, 0);
        self.list.clear();
        self.others.clear();
    }

    fn get(&self, at: u32, level: u32) -> Option<Relative> {
        let (of, range) = self.list[self.places[at as usize].checked_sub(1)? as usize];
        if of == level { Some(range) } else { self.others.get(&(at, level)).copied() }
    }

    fn insert(&mut self, at: u32, level: u32, range: Relative) {
        let place = &mut self.places[at as usize];
        if *place == 0 {
            self.list.push((level, range));
            *place = self.list.len() as u32;
        } else {
            self.others.insert((at, level), range);
        }
    }
}

impl<'c> Ranges<'c> {
    /// Begins with the words of a common section. All pages must be valid.
    pub fn new(common: &'c [u32]) -> Self {
        let mut known = Known::default();
        known.begin(common.len());
        Self { common: Code { words: common }, known, of_page: Known::default() }
    }

    /// Returns the range of all columns of a page.
    ///
    /// Cost: one visit per shape of the page, and of the common section where it has not been visited.
    pub fn of_page(&mut self, page: &Page<'_>) -> Range {
        let code = Code { words: page.words };
        match page.root {
            UNIFORM => Range::uniform(page.base),
            root if root & IN_PAGE != 0 => {
                let mut known = std::mem::take(&mut self.of_page);
                known.begin(page.words.len());
                let range = self.of_shape(&mut known, code, root & !IN_PAGE, PAGE_LEVEL).at_base(page.base);
                self.of_page = known;
                range
            }
            root => self.of_common(root, PAGE_LEVEL).at_base(page.base),
        }
    }

    fn of_common(&mut self, at: u32, level: u32) -> Relative {
        let (code, mut known) = (self.common, std::mem::take(&mut self.known));
        let range = self.of_shape(&mut known, code, at, level);
        // Shapes of the common section point only to each other, so nothing was added to `self.known`
        // meanwhile.
        self.known = known;
        range
    }

    fn of_shape(&mut self, known: &mut Known, code: Code<'_>, at: u32, level: u32) -> Relative {
        if level == LEAF_LEVEL {
            let leaf = code.leaf(at, 0);
            let [rise, differences] = leaf.reach();
            return Relative { nearest: -rise, farthest: differences, has_never: leaf.has_never() };
        }
        if let Some(range) = known.get(at, level) {
            return range;
        }
        let range = code.children(at).fold(Relative::NONE, |all, child| {
            all.joined(match child {
                Child::Never => Relative { has_never: true, ..Relative::NONE },
                Child::Uniform(delta) => Relative::at(signed(delta)),
                Child::Shape { shape, delta } => {
                    let is_page = !std::ptr::eq(code.words, self.common.words);
                    let below = level - NODE_LEVELS;
                    let child = match shape {
                        ShapeRef::Common(at) if is_page => self.of_common(at, below),
                        _ => self.of_shape(known, code, shape.at(), below),
                    };
                    child.moved(signed(delta))
                }
            })
        });
        known.insert(at, level, range);
        range
    }
}

fn signed(delta: u32) -> i64 {
    i64::from(delta as i32)
}
