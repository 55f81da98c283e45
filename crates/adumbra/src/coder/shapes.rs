//! The lists of shapes that a coder works on, and their half-words.
//!
//! A shape has an index. Those of the common section come first, in the order in which they are stored. The
//! shapes of a bundle follow. The half-words of a page depend on its shapes alone, see [`Layout`].

use super::Fault;
use super::contour::Leaf;
use crate::layout::depths::child::{Child, ShapeRef};
use crate::layout::depths::code::Code;
use crate::layout::depths::page::{BUNDLE_PAGES, IN_PAGE, PAGE_LEVEL, Page};
use crate::layout::depths::shapes::{Shape, ShapeList, ShapeReader, ShapeSet, index_in};
use crate::layout::depths::write::Writer;
use crate::layout::depths::{LEAF_LEVEL, ShapePlace, UNIFORM};

/// The shapes of a part, while it is coded.
pub(super) enum Coded<'s> {
    /// The shapes coded so far.
    SoFar(ShapeList),
    /// All shapes, for an encoder that codes them in order.
    All(&'s ShapeList),
}

impl Coded<'_> {
    /// Returns the shapes.
    #[inline(always)]
    pub(super) fn shapes(&self) -> &ShapeList {
        match self {
            Self::SoFar(shapes) => shapes,
            Self::All(shapes) => shapes,
        }
    }

    /// Records a coded shape and returns its index: `source` if all shapes are known, else the result of
    /// `push`, which adds the shape.
    #[inline(always)]
    pub(super) fn note(&mut self, source: u32, push: impl FnOnce(&mut ShapeList) -> u32) -> u32 {
        match self {
            Self::SoFar(shapes) => push(shapes),
            Self::All(_) => source,
        }
    }
}

/// The shapes of a common section, and those of a bundle behind them.
#[derive(Clone, Copy)]
pub(super) struct Pool<'s> {
    pub(super) common: &'s ShapeList,
    pub(super) own: &'s ShapeList,
}

impl<'s> Pool<'s> {
    #[inline(always)]
    fn find(self, shape: u32) -> (&'s ShapeList, u32) {
        match shape.checked_sub(self.common.len()) {
            None => (self.common, shape),
            Some(own) => (self.own, own),
        }
    }

    /// Returns the level of a shape.
    pub(super) fn level(self, shape: u32) -> u32 {
        let (list, index) = self.find(shape);
        list.level(index)
    }

    /// Returns a shape.
    #[inline(always)]
    pub(super) fn get(self, shape: u32) -> Shape<'s> {
        let (list, index) = self.find(shape);
        list.get(index)
    }
}

/// The shapes of a common section, for any number of bundles.
#[derive(Debug, Default)]
pub(crate) struct Common {
    pub(super) shapes: ShapeList,
    /// Address of each shape.
    pub(super) addresses: Vec<u32>,
    /// The places of the shapes, ascending. Empty in a decoder.
    places: Vec<ShapePlace>,
}

impl Common {
    /// Reads a valid common section. `places` are those of all its shapes, in order.
    ///
    /// # Errors
    /// Returns [`Fault`] if a writer would write other words for these shapes.
    pub(crate) fn new(words: &[u32], places: &[ShapePlace]) -> Result<Self, Fault> {
        let mut reader = ShapeReader::default();
        reader.begin(words.len());
        let mut shapes = ShapeList::default();
        for &place in places {
            reader.shape(Code { words }, place, None, &mut shapes).ok_or(Fault)?;
        }
        check_leaves(&shapes)?;
        shapes.shrink_to_fit();
        let (mut common, written) = Self::lay_out(shapes, usize::MAX)?;
        if written != words || !common.addresses.iter().eq(places.iter().map(|place| &place.at)) {
            return Err(Fault);
        }
        common.places = places.to_vec();
        Ok(common)
    }

    /// Writes shapes in the order of their indices. Returns them with the words.
    ///
    /// # Errors
    /// Returns [`Fault`] if there are more than `most_halves` half-words.
    pub(super) fn lay_out(shapes: ShapeList, most_halves: usize) -> Result<(Self, Vec<u32>), Fault> {
        let none = Self::default();
        let pool = Pool { common: &none.shapes, own: &shapes };
        let mut layout = Layout::new(&none, pool, Writer::common(), most_halves);
        for index in 0..shapes.len() {
            layout.emit(index)?;
        }
        let (words, addresses) = (layout.writer.words(), layout.addresses);
        Ok((Self { shapes, addresses, places: Vec::new() }, words))
    }
}

/// Writes shapes as half-words. The shapes of a page are in post-order from the root, children in order, each
/// written once.
pub(super) struct Layout<'s> {
    common: &'s Common,
    pool: Pool<'s>,
    /// Number of half-words that may still be written.
    most_halves: usize,
    /// Address of each shape of this part that was written, else [`UNIFORM`].
    addresses: Vec<u32>,
    /// The shapes that were written, without those of the common section.
    written: Vec<u32>,
    writer: Writer,
}

impl<'s> Layout<'s> {
    fn new(common: &'s Common, pool: Pool<'s>, writer: Writer, most_halves: usize) -> Self {
        let addresses = vec![UNIFORM; pool.own.len() as usize];
        Self { common, pool, most_halves, addresses, written: Vec::new(), writer }
    }

    /// Begins the pages of a bundle. They may have up to `most_halves` half-words together.
    pub(super) fn of_pages(common: &'s Common, own: &'s ShapeList, most_halves: usize) -> Self {
        Self::new(common, Pool { common: &common.shapes, own }, Writer::page(), most_halves)
    }

    /// Writes a page, and returns its root and its words.
    ///
    /// # Errors
    /// Returns [`Fault`] if the page is out of reach of pointers, or has too many half-words.
    pub(super) fn page(&mut self, root: Child<u32>) -> Result<(u32, Vec<u32>), Fault> {
        let Child::Shape { shape, .. } = root else { return Ok((UNIFORM, Vec::new())) };
        let root = self.emit(shape)?.root();
        let words = std::mem::replace(&mut self.writer, Writer::page()).words();
        for own in self.written.drain(..) {
            self.addresses[own as usize] = UNIFORM;
        }
        self.most_halves = self.most_halves.checked_sub(2 * words.len()).ok_or(Fault)?;
        Ok((root, words))
    }

    /// Returns where a shape is. Its address is [`UNIFORM`] if it was not written.
    fn place(&self, shape: u32) -> ShapeRef {
        match shape.checked_sub(self.common.shapes.len()) {
            None => ShapeRef::Common(self.common.addresses[shape as usize]),
            Some(own) => ShapeRef::Here(self.addresses[own as usize]),
        }
    }

    /// Writes a shape after the shapes that it points to, unless it is already written.
    fn emit(&mut self, shape: u32) -> Result<ShapeRef, Fault> {
        let place = self.place(shape);
        if place != ShapeRef::Here(UNIFORM) {
            return Ok(place);
        }
        let at = match self.pool.get(shape) {
            Shape::Leaf(halves) => self.writer.leaf(halves),
            Shape::Node(node) => {
                let mut placed = [Child::Never; 16];
                for (placed, child) in placed.iter_mut().zip(node.all()) {
                    *placed = child.try_map(|shape| self.emit(shape))?;
                }
                self.writer.node(&placed).map_err(|_| Fault)?
            }
        };
        if self.writer.half_count() > self.most_halves {
            return Err(Fault);
        }
        let own = shape - self.common.shapes.len();
        self.addresses[own as usize] = at;
        self.written.push(own);
        Ok(ShapeRef::Here(at))
    }
}

/// Reads the valid pages of a bundle. Returns their shapes, equal ones listed once, and their roots as
/// children.
///
/// # Errors
/// Returns [`Fault`] if a writer would write a page in another way.
pub(super) fn read_pages(
    pages: &[Page<'_>; BUNDLE_PAGES],
    common: &Common,
) -> Result<(ShapeList, [Child<u32>; BUNDLE_PAGES]), Fault> {
    let before = common.shapes.len();
    if common.places.len() != before as usize {
        // The section was decoded, so the places of its shapes are not known.
        return Err(Fault);
    }
    let mut reader = ShapeReader::default();
    let (mut of_page, mut merged) = (ShapeList::default(), Vec::new());
    let mut set = ShapeSet::new(true);
    let mut roots = [Child::Never; BUNDLE_PAGES];
    for (root, page) in roots.iter_mut().zip(pages) {
        let place = ShapePlace { at: page.root & !IN_PAGE, level: PAGE_LEVEL };
        let shape = match page.root {
            UNIFORM if *page == Page::OUTSIDE => continue,
            UNIFORM => {
                *root = Child::Uniform(page.base);
                continue;
            }
            in_page if in_page & IN_PAGE != 0 => {
                reader.begin(page.words.len());
                of_page.clear();
                let code = Code { words: page.words };
                reader.shape(code, place, Some(&common.places), &mut of_page).ok_or(Fault)?;
                merged.clear();
                for index in 0..of_page.len() {
                    let known =
                        |shape: u32| shape.checked_sub(before).map_or(shape, |own| merged[own as usize]);
                    let index = match of_page.get(index) {
                        Shape::Leaf(halves) => set.leaf(halves),
                        Shape::Node(node) => {
                            set.node(node.level(), &node.all().map(|child| child.map(known)))
                        }
                    };
                    merged.push(before + index);
                }
                merged[merged.len() - 1]
            }
            _ => index_in(&common.places, place).ok_or(Fault)?,
        };
        *root = Child::Shape { shape, delta: page.base };
    }
    let shapes = set.into_list();
    check_leaves(&shapes)?;
    Ok((shapes, roots))
}

/// Checks that a writer would write the leaves of a list as they are.
fn check_leaves(shapes: &ShapeList) -> Result<(), Fault> {
    let is_short = |&leaf: &u32| match shapes.get(leaf) {
        Shape::Leaf(halves) => Leaf::read(halves).is_some(),
        Shape::Node(_) => true,
    };
    if shapes.of_level(LEAF_LEVEL).iter().all(is_short) { Ok(()) } else { Err(Fault) }
}
