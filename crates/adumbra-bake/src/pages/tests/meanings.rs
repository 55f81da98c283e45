//! The shapes of a tree by their meaning, wherever they are stored, and the pointers of its pages.

use std::collections::{HashMap, HashSet};

use adumbra::layout::depths::child::{Child, ShapeRef};
use adumbra::layout::depths::code::{Code, NEAR};
use adumbra::layout::depths::leaf::LeafHead;
use adumbra::layout::depths::page::{IN_PAGE, PAGE_LEVEL, Page};
use adumbra::layout::depths::{DepthTree, LEAF_LEVEL, NODE_LEVELS, UNIFORM};

/// The meaning of a shape, regardless of its place: its level, and a leaf's half-words or a node's children.
/// A child has its kind, its difference, and the number of its shape.
type Meaning = (u32, Vec<[usize; 3]>);

/// A part of a tree's code: `None` is the common section, else the number of a page.
pub(super) type Where = Option<usize>;

/// The different shapes of a tree.
#[derive(Default)]
pub(super) struct Meanings {
    pub(super) numbers: HashMap<Meaning, usize>,
    pub(super) shapes: Vec<Found>,
    pub(super) pointers: Vec<Pointer>,
}

/// A pointer of a node in a page.
pub(super) struct Pointer {
    pub(super) delta: i32,
    /// Half-words back, if the pointer is relative.
    pub(super) back: Option<u32>,
    /// Address of the shape that it points to.
    pub(super) at: u32,
}

impl Pointer {
    pub(super) fn is_wide(&self) -> bool {
        i16::try_from(self.delta).is_err()
    }

    pub(super) fn is_far(&self) -> bool {
        self.back.unwrap_or(self.at) >= NEAR
    }
}

/// A shape.
#[derive(Default)]
pub(super) struct Found {
    pub(super) level: u32,
    /// Its places, and its half-words there.
    pub(super) halves: HashMap<(Where, u32), u32>,
    /// The pages that have the shape.
    pub(super) pages: HashSet<usize>,
}

/// A page, while its shapes are visited.
struct Visit<'t> {
    number: usize,
    words: &'t [u32],
    common: &'t [u32],
    known: HashMap<(Where, u32, u32), usize>,
}

impl Meanings {
    pub(super) fn of(tree: &DepthTree) -> Self {
        let mut found = Self::default();
        let [across, down] = tree.page_dims();
        for (number, place) in (0..down).flat_map(|y| (0..across).map(move |x| [x, y])).enumerate() {
            let Page { root, words, .. } = tree.page(place);
            let mut visit = Visit { number, words, common: tree.common(), known: HashMap::new() };
            match root {
                UNIFORM => {}
                root if root & IN_PAGE != 0 => {
                    found.shape(&mut visit, Some(number), root & !IN_PAGE, PAGE_LEVEL);
                }
                root => {
                    found.shape(&mut visit, None, root, PAGE_LEVEL);
                }
            }
        }
        found
    }

    /// Visits a shape and the shapes below it, and returns its number.
    fn shape(&mut self, visit: &mut Visit<'_>, part: Where, at: u32, level: u32) -> usize {
        if let Some(&known) = visit.known.get(&(part, at, level)) {
            return known;
        }
        let code = Code { words: if part.is_none() { visit.common } else { visit.words } };
        let (length, content) = if level == LEAF_LEVEL {
            let length = LeafHead::new(code.half(at)).length();
            (length, (at..at + length).map(|at| [code.half(at) as usize, 0, 0]).collect())
        } else {
            let child = |c| match code.child(at, c) {
                Child::Never => [0, 0, 0],
                Child::Uniform(delta) => [1, delta as usize, 0],
                Child::Shape { shape, delta } => {
                    let (to, is_here) = (shape.at(), matches!(shape, ShapeRef::Here(_)));
                    if part.is_some() {
                        let back = is_here.then(|| at - to);
                        self.pointers.push(Pointer { delta: delta as i32, back, at: to });
                    }
                    let part = if is_here { part } else { None };
                    [2, delta as usize, self.shape(visit, part, to, level - NODE_LEVELS)]
                }
            };
            let content = (0..16).map(child).collect();
            let [low, high, kind] = [0, 1, 2].map(|h| code.half(at + h));
            let short = high & !low & !kind;
            (3 + low.count_ones() + 2 * high.count_ones() - short.count_ones(), content)
        };
        let next = self.numbers.len();
        let number = *self.numbers.entry((level, content)).or_insert(next);
        if number == next {
            self.shapes.push(Found { level, ..Found::default() });
        }
        let shape = &mut self.shapes[number];
        shape.halves.insert((part, at), length);
        shape.pages.insert(visit.number);
        visit.known.insert((part, at, level), number);
        number
    }
}
