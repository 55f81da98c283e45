//! The common section: shapes that several pages have, in an order that depends on the shapes alone.

use std::cmp::Reverse;
use std::collections::HashMap;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

use adumbra::layout::depths::ShapePlace;
use adumbra::layout::depths::write::{OutOfReach, Place, Writer};
use rayon::prelude::*;

use super::shapes::{Child, Children, Reader, Shape, placed};
use super::store::PageStore;

/// Number of pages that must have a shape. In the common section a shape of three pages saves twice its bytes for each
/// that is always resident; one of two pages would save as many as it costs.
const LEAST_PAGES: usize = 3;
/// Number of hashes that are sorted at a time: 64 MiB.
const MAX_HASHES: u64 = 1 << 22;
/// Half-words per shape, about. It only decides how many hashes are sorted at a time.
const HALVES_PER_SHAPE: u64 = 8;

/// The common section of a grid.
#[derive(Debug, Default)]
pub(super) struct Common {
    pub(super) words: Vec<u32>,
    /// The shapes, by address.
    pub(super) shapes: Vec<ShapePlace>,
    /// The address of each shape, by its hash.
    pub(super) addresses: HashMap<u128, u32>,
}

impl Common {
    /// Finds the shapes that several pages of a store have, and lays them out. `numbers` are those of the pages.
    ///
    /// Lost pages are skipped; the store's spill knows of them.
    ///
    /// # Errors
    /// Returns [`OutOfReach`] if the section is too large.
    pub(super) fn of(store: &PageStore, numbers: &[u32]) -> Result<Self, OutOfReach> {
        let shared = Shared::new(hashes_of_several_pages(store, numbers));
        numbers.par_iter().for_each_init(Reader::default, |reader, &number| {
            if let Some((words, root)) = store.get(number) {
                reader.read(&words, root, true);
                shared.visit(reader);
            }
        });
        shared.lay_out()
    }
}

/// Returns the bytes of the hashes that are sorted at a time, about.
pub(super) fn sorting_bytes(store: &PageStore) -> u64 {
    (store.halves() / HALVES_PER_SHAPE).min(MAX_HASHES) * size_of::<u128>() as u64
}

/// Returns the hashes of all shapes that at least [`LEAST_PAGES`] pages have, sorted.
fn hashes_of_several_pages(store: &PageStore, numbers: &[u32]) -> Vec<u128> {
    let passes = (store.halves() / HALVES_PER_SHAPE).div_ceil(MAX_HASHES).next_power_of_two();
    let mut found = Vec::new();
    for pass in 0..passes {
        // Hashes are uniform, so each pass has about as many.
        let is_here = |hash: u128| (hash >> 64) as u64 & (passes - 1) == pass;
        let collected = numbers.par_iter().fold(
            || (Reader::default(), Vec::new()),
            |(mut reader, mut hashes), &number| {
                if let Some((words, root)) = store.get(number) {
                    reader.read(&words, root, true);
                    hashes.extend(reader.hashes.iter().copied().filter(|&hash| is_here(hash)));
                }
                (reader, hashes)
            },
        );
        let mut hashes = collected.map(|(_, hashes)| hashes).reduce(Vec::new, |mut all, mut more| {
            all.append(&mut more);
            all
        });
        hashes.par_sort_unstable();
        let runs = hashes.chunk_by(|a, b| a == b).filter(|run| run.len() >= LEAST_PAGES);
        found.extend(runs.map(|run| run[0]));
    }
    found.sort_unstable();
    found
}

/// Shapes that several pages have, while their contents are collected.
struct Shared {
    hashes: Vec<u128>,
    indices: HashMap<u128, u32>,
    found: Vec<Found>,
}

#[derive(Default)]
struct Found {
    /// Number of nodes and roots that point to the shape. A node that several pages have counts once if it is shared,
    /// else once per page.
    pointers: AtomicU32,
    content: OnceLock<(u32, Content)>,
}

enum Content {
    Leaf(Box<[u16]>),
    /// Children have indices of shared shapes.
    Node(Box<Children>),
}

impl Content {
    /// Returns the number of half-words, if all pointers are near and none is short.
    fn length(&self) -> u64 {
        let narrow = |delta: u32| i16::try_from(delta as i32).is_ok();
        match self {
            Self::Leaf(halves) => halves.len() as u64,
            Self::Node(children) => children.iter().fold(3, |sum, child| {
                sum + match *child {
                    Child::Never | Child::Uniform(0) => 0,
                    Child::Shape { delta: 0, .. } => 1,
                    Child::Uniform(delta) if narrow(delta) => 1,
                    Child::Shape { delta, .. } if narrow(delta) => 2,
                    Child::Uniform(_) | Child::Shape { .. } => 3,
                }
            }),
        }
    }
}

impl Shared {
    fn new(hashes: Vec<u128>) -> Self {
        let indices = hashes.iter().zip(0..).map(|(&hash, index)| (hash, index)).collect();
        let found = hashes.iter().map(|_| Found::default()).collect();
        Self { hashes, indices, found }
    }

    /// Notes the shapes of a page.
    fn visit(&self, reader: &Reader) {
        let shapes = reader.shapes();
        let shared = |index: u32| self.indices.get(&reader.hashes[index as usize]).copied();
        let count = |index: u32| {
            if let Some(shared) = shared(index) {
                self.found[shared as usize].pointers.fetch_add(1, Ordering::Relaxed);
            }
        };
        let count_children = |children: &Children| {
            for child in children {
                if let Child::Shape { index, .. } = *child {
                    count(index);
                }
            }
        };
        count(reader.hashes.len() as u32 - 1);
        for (index, shape) in (0_u32..).zip(&shapes.list) {
            match (shared(index), *shape) {
                (Some(found), shape) => {
                    self.found[found as usize].content.get_or_init(|| {
                        let content = match shape {
                            Shape::Leaf { first, length } => Content::Leaf(shapes.leaf(first, length).into()),
                            Shape::Node { children, .. } => {
                                let children = shapes.children(children);
                                count_children(children);
                                // What all these pages have in a shape, they have below it.
                                Content::Node(Box::new(children.map(|child| match child {
                                    Child::Shape { delta, index } => {
                                        Child::Shape { delta, index: shared(index).unwrap_or(u32::MAX) }
                                    }
                                    other => other,
                                })))
                            }
                        };
                        (shape.level(), content)
                    });
                }
                (None, Shape::Node { children, .. }) => count_children(shapes.children(children)),
                (None, Shape::Leaf { .. }) => {}
            }
        }
    }

    /// Writes the shapes, those with the most pointers for their length first, each after what it leads to.
    fn lay_out(&self) -> Result<Common, OutOfReach> {
        let mut order: Vec<u32> = (0..self.found.len() as u32)
            .filter(|&i| self.found[i as usize].content.get().is_some())
            .collect();
        order.sort_by_cached_key(|&index| {
            let found = &self.found[index as usize];
            let (level, length) =
                found.content.get().map_or((0, 1), |(level, content)| (*level, content.length()));
            let pointers = u64::from(found.pointers.load(Ordering::Relaxed)) << 16;
            (Reverse(pointers / length), level, self.hashes[index as usize])
        });
        let mut writer = Writer::common();
        let mut addresses = vec![None; self.found.len()];
        for index in order {
            self.emit(index, &mut writer, &mut addresses)?;
        }
        let contents = self.found.iter().map(|found| found.content.get());
        let shape = |(content, at): (Option<&(u32, Content)>, &Option<u32>)| {
            Some(ShapePlace { at: (*at)?, level: content?.0 })
        };
        let mut shapes: Vec<ShapePlace> = contents.zip(&addresses).filter_map(shape).collect();
        shapes.sort_unstable();
        let places = self.hashes.iter().zip(addresses);
        let addresses = places.filter_map(|(&hash, at)| at.map(|at| (hash, at))).collect();
        Ok(Common { words: writer.words(), shapes, addresses })
    }

    fn emit(
        &self,
        index: u32,
        writer: &mut Writer,
        addresses: &mut [Option<u32>],
    ) -> Result<u32, OutOfReach> {
        if let Some(known) = addresses[index as usize] {
            return Ok(known);
        }
        let at = match self.found[index as usize].content.get() {
            None => unreachable!("a page has every shape that is pointed to"),
            Some((_, Content::Leaf(halves))) => writer.leaf(halves),
            Some((_, Content::Node(children))) => {
                for child in children.iter() {
                    if let Child::Shape { index, .. } = *child {
                        self.emit(index, writer, addresses)?;
                    }
                }
                let place = |child: u32| Place::Here(addresses[child as usize].unwrap_or_default());
                writer.node(&placed(children, place))?
            }
        };
        addresses[index as usize] = Some(at);
        Ok(at)
    }
}
