//! The common section: shapes that several pages have, in an order that depends on the shapes alone.

use std::cmp::Reverse;
use std::sync::{Mutex, MutexGuard};

use adumbra::layout::depths::ShapePlace;
use adumbra::layout::depths::child::{Child, Children, ShapeRef};
use adumbra::layout::depths::shapes::{Shape, ShapeList};
use adumbra::layout::depths::write::{OutOfReach, Writer};
use hashbrown::HashTable;
use rayon::prelude::*;

use super::shapes::Reader;
use super::sketch::{OFTEN, Sketch};
use super::store::PageStore;

/// Number of pages that must have a shape. In the common section, which is always resident, a shape of three
/// pages saves two copies and costs one. A shape of two pages would save only as much as it costs.
const LEAST_PAGES: u32 = OFTEN as u32;
/// Half-words per shape, about. It only decides the size of the sketch.
const HALVES_PER_SHAPE: u64 = 8;
/// Parts of the table of shapes, each behind its own lock.
const SHARDS: usize = 1 << SHARD_BITS;
const SHARD_BITS: u32 = 8;

/// The common section of a grid.
#[derive(Debug, Default)]
pub(super) struct Common {
    pub(super) words: Vec<u32>,
    /// The shapes, by address.
    pub(super) shapes: Vec<ShapePlace>,
    addresses: Addresses,
}

impl Common {
    /// Finds the shapes that several pages of a store have, and lays them out. `numbers` are those of the
    /// pages.
    ///
    /// Skips lost pages; the store's spill has recorded the failure.
    ///
    /// # Errors
    /// Returns [`OutOfReach`] if the section is too large.
    pub(super) fn of(store: &PageStore, numbers: &[u32]) -> Result<Self, OutOfReach> {
        let for_each_page = |visit: &(dyn Fn(&mut Reader, &[u32], u32) + Sync)| {
            numbers.par_iter().for_each_init(Reader::default, |reader, &number| {
                if let Some((words, root)) = store.get(number) {
                    visit(reader, &words, root);
                }
            });
        };
        let sketch = Sketch::new(shapes_about(store));
        for_each_page(&|reader, words, root| {
            reader.read(words, root);
            reader.hashes.iter().for_each(|&hash| sketch.count(hash));
        });
        let found = Candidates::new(sketch);
        for_each_page(&|reader, words, root| {
            reader.read(words, root);
            found.visit(reader);
        });
        found.lay_out()
    }

    /// Returns the address of the shape with this hash.
    pub(super) fn address(&self, hash: u128) -> Option<u32> {
        self.addresses.get(split(hash))
    }
}

/// Returns the approximate bytes that finding the common section needs.
pub(super) fn finding_bytes(store: &PageStore) -> u64 {
    let shapes = shapes_about(store);
    // Of the large worlds measured, one shape in 20 is common. A node takes at most as much as its children.
    Sketch::bytes(shapes) + shapes / 20 * (size_of::<Candidate>() + size_of::<Children<u32>>()) as u64
}

fn shapes_about(store: &PageStore) -> u64 {
    store.halves() / HALVES_PER_SHAPE
}

/// Addresses of shapes by their hashes.
#[derive(Debug, Default)]
struct Addresses {
    list: Vec<([u64; 2], u32)>,
    /// Indices in the list.
    table: HashTable<u32>,
}

impl Addresses {
    fn get(&self, hash: [u64; 2]) -> Option<u32> {
        let index = *self.table.find(hash[0], |&index| self.list[index as usize].0 == hash)?;
        Some(self.list[index as usize].1)
    }

    fn add(&mut self, hash: [u64; 2], address: u32) {
        let Self { list, table } = self;
        let index = list.len() as u32;
        list.push((hash, address));
        table.insert_unique(hash[0], index, |&index| list[index as usize].0[0]);
    }
}

/// Shapes that several pages seem to have, while they are counted exactly and their contents are collected.
struct Candidates {
    sketch: Sketch,
    shards: Vec<Mutex<Shard>>,
}

/// The shapes whose hashes have the same [`SHARD_BITS`], and their contents.
#[derive(Default)]
struct Shard {
    candidates: Vec<Candidate>,
    /// Indices of the shapes by hash.
    table: HashTable<u32>,
    /// Contents. Children that are shapes have their ids.
    list: ShapeList,
}

struct Candidate {
    /// The hash, low half first. Not a `u128`, which would need padding for its alignment.
    hash: [u64; 2],
    /// Number of pages that have the shape.
    pages: u32,
    /// Number of nodes and roots that point to the shape. A node that is common counts once, any other once
    /// per page.
    pointers: u32,
    /// The index of its content in its shard's list, once that is collected.
    shape: u32,
}

fn split(hash: u128) -> [u64; 2] {
    [hash as u64, (hash >> 64) as u64]
}

/// A candidate: its shard in the low [`SHARD_BITS`], and its index there.
type Id = u32;

/// The id of a child that is not a candidate, below a node that too few pages have.
/// [`UNIFORM`](adumbra::layout::depths::UNIFORM) is not free: lists of shapes use it.
const NO_CANDIDATE: Id = u32::MAX - 1;

fn shard_and_index(id: Id) -> (usize, usize) {
    (id as usize % SHARDS, (id >> SHARD_BITS) as usize)
}

impl Candidates {
    fn new(sketch: Sketch) -> Self {
        Self { sketch, shards: (0..SHARDS).map(|_| Mutex::default()).collect() }
    }

    fn shard(&self, shard: usize) -> MutexGuard<'_, Shard> {
        self.shards[shard].lock().unwrap_or_else(|e| e.into_inner())
    }

    /// Notes the shapes of a page.
    fn visit(&self, page: &Reader) {
        let noted: Vec<Option<Noted>> =
            page.hashes.iter().map(|&hash| self.sketch.came_often(hash).then(|| self.note(hash))).collect();
        let id = |index: u32| noted[index as usize].map(|noted| noted.id);
        let count = |index: u32| {
            if let Some((shard, index)) = id(index).map(shard_and_index) {
                self.shard(shard).candidates[index].pointers += 1;
            }
        };
        count(page.hashes.len() as u32 - 1);
        for (shape, &noted) in (0..).zip(&noted) {
            if noted.is_some_and(|noted| !noted.is_new) {
                continue;
            }
            let candidate = noted.map(|noted| shard_and_index(noted.id));
            match page.list.get(shape) {
                Shape::Leaf(halves) => {
                    let Some((shard, index)) = candidate else { continue };
                    let Shard { candidates, list, .. } = &mut *self.shard(shard);
                    candidates[index].shape = list.push_leaf(halves.iter().copied());
                }
                Shape::Node(node) => {
                    let children = node.all();
                    for child in children {
                        if let Child::Shape { shape, .. } = child {
                            count(shape);
                        }
                    }
                    let Some((shard, index)) = candidate else { continue };
                    // Pages that share a shape share all shapes below it.
                    let ids = children.map(|child| child.map(|shape| id(shape).unwrap_or(NO_CANDIDATE)));
                    let Shard { candidates, list, .. } = &mut *self.shard(shard);
                    candidates[index].shape = list.push_node(node.level(), &ids);
                }
            }
        }
    }

    /// Counts a page's shape.
    fn note(&self, hash: u128) -> Noted {
        let hash = split(hash);
        let shard_number = hash[1] as usize % SHARDS;
        let mut shard = self.shard(shard_number);
        let Shard { candidates, table, .. } = &mut *shard;
        let next = candidates.len() as u32;
        let is_same = |&index: &u32| candidates[index as usize].hash == hash;
        let hash_of = |&index: &u32| candidates[index as usize].hash[0];
        let index = *table.entry(hash[0], is_same, hash_of).or_insert(next).get();
        if index == next {
            candidates.push(Candidate { hash, pages: 0, pointers: 0, shape: 0 });
        }
        candidates[index as usize].pages += 1;
        Noted { id: index << SHARD_BITS | shard_number as u32, is_new: index == next }
    }

    /// Writes the shapes, those with the most pointers for their length first, and each after the shapes that
    /// it points to.
    fn lay_out(self) -> Result<Common, OutOfReach> {
        let shards =
            self.shards.into_iter().map(|shard| shard.into_inner().unwrap_or_else(|e| e.into_inner()));
        let mut shapes = Shapes(shards.collect());
        shapes.count_pointers_of_dropped();
        let mut order = shapes.ids();
        order.sort_by_cached_key(|&id| {
            let (shard, candidate) = shapes.get(id);
            let [low, high] = candidate.hash;
            let weight = (u64::from(candidate.pointers) << 16) / shard.length(candidate.shape);
            (Reverse(weight), shard.list.level(candidate.shape), high, low)
        });
        let mut writer = Writer::common();
        let mut common = Common::default();
        for id in order {
            shapes.emit(id, &mut writer, &mut common)?;
        }
        common.shapes.sort_unstable();
        common.words = writer.words();
        Ok(common)
    }
}

/// The result of [`Candidates::note`].
#[derive(Clone, Copy)]
struct Noted {
    id: Id,
    /// Whether no page had the shape before, so that its content is still to be collected.
    is_new: bool,
}

impl Shard {
    /// Returns the number of half-words of a shape, if all pointers are near and none is short.
    fn length(&self, shape: u32) -> u64 {
        let narrow = |delta: u32| i16::try_from(delta as i32).is_ok();
        match self.list.get(shape) {
            Shape::Leaf(halves) => halves.len() as u64,
            Shape::Node(node) => node.all().into_iter().fold(3, |sum, child| {
                sum + match child {
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

/// All candidates, by shard.
struct Shapes(Vec<Shard>);

impl Shapes {
    fn get(&self, id: Id) -> (&Shard, &Candidate) {
        let (shard, index) = shard_and_index(id);
        (&self.0[shard], &self.0[shard].candidates[index])
    }

    /// Counts the pointers of candidates that too few pages have, once per page, so that the result does not
    /// depend on which shapes the sketch mistakes for common ones.
    fn count_pointers_of_dropped(&mut self) {
        let mut more = Vec::new();
        for shard in &self.0 {
            for candidate in shard.candidates.iter().filter(|candidate| candidate.pages < LEAST_PAGES) {
                let Shape::Node(node) = shard.list.get(candidate.shape) else { continue };
                for child in node.all() {
                    match child {
                        Child::Shape { shape, .. } if shape != NO_CANDIDATE => {
                            more.push((shape, candidate.pages - 1));
                        }
                        _ => {}
                    }
                }
            }
        }
        for (id, count) in more {
            let (shard, index) = shard_and_index(id);
            self.0[shard].candidates[index].pointers += count;
        }
    }

    /// Returns the candidates that enough pages have.
    fn ids(&self) -> Vec<Id> {
        let of_shard = |(number, shard): (u32, &Shard)| {
            let several =
                (0_u32..).zip(&shard.candidates).filter(|(_, candidate)| candidate.pages >= LEAST_PAGES);
            several.map(|(index, _)| index << SHARD_BITS | number).collect::<Vec<_>>()
        };
        (0..).zip(&self.0).flat_map(of_shard).collect()
    }

    fn emit(&self, id: Id, writer: &mut Writer, common: &mut Common) -> Result<u32, OutOfReach> {
        let (shard, candidate) = self.get(id);
        if let Some(known) = common.addresses.get(candidate.hash) {
            return Ok(known);
        }
        let at = match shard.list.get(candidate.shape) {
            Shape::Leaf(halves) => writer.leaf(halves),
            Shape::Node(node) => {
                let mut placed = [Child::Never; 16];
                for (placed, child) in placed.iter_mut().zip(node.all()) {
                    *placed = child.try_map(|shape| self.emit(shape, writer, common).map(ShapeRef::Here))?;
                }
                writer.node(&placed)?
            }
        };
        common.addresses.add(candidate.hash, at);
        common.shapes.push(ShapePlace { at, level: shard.list.level(candidate.shape) });
        Ok(at)
    }
}
