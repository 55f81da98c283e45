//! Finds the objects of a bake, and writes those that are missing as soon as their parts are done.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use adumbra::layout::depths::page::{PAGE_LEVEL, page_dims};
use rayon::prelude::*;

use super::object::{self, PageObject};
use super::{Fetched, ObjectKey, Objects};
use crate::error::{Error, Result};

/// How a grid is cut into parts: a part has a root block, or all root blocks of a page.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    /// Number of voxels of the grid along x and y.
    size: [u32; 2],
    root_level: u32,
}

impl Parts {
    /// Cuts a grid whose root blocks have this level.
    pub(crate) fn new(size: [u32; 3], root_level: u32) -> Self {
        Self { size: [size[0], size[1]], root_level }
    }

    fn level(&self) -> u32 {
        self.root_level.max(PAGE_LEVEL)
    }

    fn dims(&self) -> [u32; 2] {
        self.size.map(|n| n.div_ceil(1 << self.level()))
    }

    /// Returns the number of parts.
    pub(crate) fn count(&self) -> usize {
        self.dims().iter().product::<u32>() as usize
    }

    fn place(&self, part: usize) -> [u32; 2] {
        let across = self.dims()[0];
        [part as u32 % across, part as u32 / across]
    }

    /// Returns the first texel of a part along x and y, and the number of its texels inside the grid.
    pub(crate) fn texels(&self, part: usize) -> [[u32; 2]; 2] {
        let corner = self.place(part).map(|n| n << self.level());
        [corner, [0, 1].map(|a| (1 << self.level()).min(self.size[a] - corner[a]))]
    }

    /// Returns the part at a page.
    pub(super) fn at_page(&self, page: [u32; 2]) -> usize {
        let [x, y] = page.map(|n| n >> (self.level() - PAGE_LEVEL));
        (y * self.dims()[0] + x) as usize
    }

    /// Returns the part that has a root block, by the block's number, x fastest.
    pub(super) fn of_tile(&self, tile: usize) -> usize {
        let across = self.size[0].div_ceil(1 << self.root_level);
        let at = [tile as u32 % across, tile as u32 / across];
        let [x, y] = at.map(|n| n >> (self.level() - self.root_level));
        (y * self.dims()[0] + x) as usize
    }

    /// Returns the root blocks of a part, x fastest.
    pub(crate) fn tiles(&self, part: usize) -> impl Iterator<Item = usize> {
        let tiles = self.size.map(|n| n.div_ceil(1 << self.root_level));
        inside(self.place(part), self.level() - self.root_level, tiles)
            .map(move |[x, y]| (y * tiles[0] + x) as usize)
    }

    /// Returns the pages of a part, x fastest.
    pub(crate) fn pages(&self, part: usize) -> impl Iterator<Item = [u32; 2]> {
        inside(self.place(part), self.level() - PAGE_LEVEL, page_dims([self.size[0], self.size[1], 1]))
    }

    /// Returns the number of pages of a part along x and y.
    pub(super) fn page_dims(&self, part: usize) -> [u32; 2] {
        let side = 1 << (self.level() - PAGE_LEVEL);
        let [at, all] = [self.place(part), page_dims([self.size[0], self.size[1], 1])];
        [0, 1].map(|a| side.min(all[a] - at[a] * side))
    }
}

/// Returns the squares of a grid of `dims` that are in the square at `place` of 2^shift a side, x fastest.
fn inside(place: [u32; 2], shift: u32, dims: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    let [xs, ys] = [0, 1].map(|a| place[a] << shift..((place[a] + 1) << shift).min(dims[a]));
    ys.flat_map(move |y| xs.clone().map(move |x| [x, y]))
}

/// Copies of an object's bytes while it is read: the bytes, the words of its pages, and those that are checked and kept.
const COPIES: u64 = 4;

/// The objects of a bake.
#[derive(Debug)]
pub(crate) struct Keeper {
    objects: Arc<dyn Objects>,
    pub(crate) parts: Parts,
    /// The key of each part; `None` for parts that the bake leaves out.
    keys: Vec<Option<ObjectKey>>,
    /// Whether the object of a part was there.
    found: Vec<AtomicBool>,
    /// Memory for objects while they are read, if it is limited.
    room_bytes: Option<u64>,
    /// Held by whoever reads an object that takes more than its thread's share of the room.
    large: Mutex<()>,
    /// Number of objects that do not fit the room, and bytes of the longest.
    left_out: AtomicUsize,
    left_out_bytes: AtomicU64,
    failure: Mutex<Option<Error>>,
}

impl Keeper {
    /// `keys` are those of some parts, each with its number.
    pub(crate) fn new(
        objects: &Arc<dyn Objects>,
        parts: Parts,
        keys: impl IntoIterator<Item = (usize, ObjectKey)>,
    ) -> Self {
        let found = (0..parts.count()).map(|_| AtomicBool::new(false)).collect();
        let mut all = vec![None; parts.count()];
        keys.into_iter().for_each(|(part, key)| all[part] = Some(key));
        Self {
            objects: Arc::clone(objects),
            parts,
            keys: all,
            found,
            room_bytes: None,
            large: Mutex::default(),
            left_out: AtomicUsize::new(0),
            left_out_bytes: AtomicU64::new(0),
            failure: Mutex::default(),
        }
    }

    /// Limits the memory for objects while they are read. One that takes more is made again.
    pub(crate) fn within(self, room_bytes: Option<u64>) -> Self {
        Self { room_bytes, ..self }
    }

    /// Reads all objects that are there, on all threads, and passes the pages of each to `take`, x fastest.
    pub(crate) fn find(&self, take: impl Fn(usize, Vec<PageObject>) + Sync) {
        (0..self.keys.len()).into_par_iter().for_each(|part| {
            let Some(key) = &self.keys[part] else { return };
            let (dims, take) = (self.parts.page_dims(part), |pages| take(part, pages));
            let most_bytes = object::most_bytes(dims);
            let Some(room_bytes) = self.room_bytes else {
                self.read(part, key, most_bytes, take);
                return;
            };
            // Half of the room is for all threads, the other half for a large object.
            let large_bytes = room_bytes / (2 * COPIES);
            let small_bytes = large_bytes / rayon::current_num_threads() as u64;
            match self.read(part, key, most_bytes.min(small_bytes), take) {
                Some(bytes) if bytes > most_bytes => {}
                Some(bytes) if bytes > large_bytes => {
                    self.left_out.fetch_add(1, Ordering::Relaxed);
                    self.left_out_bytes.fetch_max(bytes, Ordering::Relaxed);
                }
                Some(_) => {
                    let _alone = self.large.lock().unwrap_or_else(|e| e.into_inner());
                    self.read(part, key, most_bytes.min(large_bytes), take);
                }
                None => {}
            }
        });
    }

    /// Returns the number of objects that did not fit the room, and the room that the longest of them would have needed.
    pub(crate) fn left_out(&self) -> (usize, u64) {
        let bytes = 2 * COPIES * self.left_out_bytes.load(Ordering::Relaxed);
        (self.left_out.load(Ordering::Relaxed), bytes)
    }

    /// Reads the object of a part, and passes its pages to `take`. Returns the length of one that is longer than
    /// `most_bytes`. What is damaged is made again.
    fn read(
        &self,
        part: usize,
        key: &ObjectKey,
        most_bytes: u64,
        take: impl FnOnce(Vec<PageObject>),
    ) -> Option<u64> {
        let bytes = match self.objects.get(key, most_bytes) {
            Ok(Fetched::Whole(bytes)) => bytes,
            Ok(Fetched::TooLong(bytes)) => return Some(bytes),
            Ok(Fetched::Nothing) => return None,
            Err(error) => {
                self.fail(error.into());
                return None;
            }
        };
        let dims = self.parts.page_dims(part);
        let pages = if self.objects.are_own() {
            object::from_own_bytes(&bytes, dims)
        } else {
            object::from_bytes(key, &bytes, dims)
        };
        if let Some(pages) = pages {
            take(pages);
            self.found[part].store(true, Ordering::Relaxed);
        }
        None
    }

    /// Whether the object of a root block's part was there.
    pub(crate) fn has_tile(&self, tile: usize) -> bool {
        self.has(self.parts.of_tile(tile))
    }

    /// Whether the object of a part was there.
    pub(crate) fn has(&self, part: usize) -> bool {
        self.found[part].load(Ordering::Relaxed)
    }

    /// Returns the number of root blocks whose objects were there.
    pub(crate) fn found_tiles(&self) -> usize {
        let found = (0..self.parts.count()).filter(|&part| self.has(part));
        found.map(|part| self.parts.tiles(part).count()).sum()
    }

    /// Returns the part at a page.
    pub(crate) fn part_at(&self, page: [u32; 2]) -> usize {
        self.parts.at_page(page)
    }

    /// Keeps the pages of a part: root, base and words of each, x fastest.
    pub(crate) fn keep<'p>(&self, part: usize, pages: impl Iterator<Item = (u32, u32, &'p [u32])> + Clone) {
        let Some(key) = &self.keys[part] else { return };
        if let Err(error) = self.objects.put(key, &object::to_bytes(key, pages)) {
            self.fail(error.into());
        }
    }

    /// Checks that all objects could be read and written.
    ///
    /// # Errors
    /// Returns the first [`Error::Io`], once.
    pub(crate) fn check(&self) -> Result<()> {
        self.failure.lock().unwrap_or_else(|e| e.into_inner()).take().map_or(Ok(()), Err)
    }

    fn fail(&self, error: Error) {
        self.failure.lock().unwrap_or_else(|e| e.into_inner()).get_or_insert(error);
    }
}
