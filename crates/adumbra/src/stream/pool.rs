//! The pool: an array of words with the tables, the common sections and the resident pages of a file. It
//! returns the writes to these words; the owner of the words performs them.
//!
//! | part | words |
//! |---|---|
//! | reserved | words for the host's own use, before all others |
//! | tables | two words per block, and a weight per page if levels fade, of each level in use, the finest first |
//! | common sections | of each level in use, the finest first |
//! | pages | each at a multiple of 64 words |
//!
//! Worked value: a level's common section begins at word 1000. A page whose root is 0x80000010 is put at
//! word 4096. At block level 9, its block is 2 · (4096 − 1000) + 0x10 = 6208 and the root's base.

use std::collections::VecDeque;
use std::ops::Range;

use range_alloc::RangeAllocator;

use crate::file::Contents;
use crate::gpu::WordPlaces;
use crate::grid::LightGrid;
use crate::layout::depths::page::{HEAD_WORDS, PAGE_LEVEL, Page, bundles, page_dims, pages_of};
use crate::layout::depths::top::{block_dims, block_level};
use crate::layout::depths::{ABSENT, TreeWords, UNIFORM};
use crate::stream::StreamOptions;
use crate::stream::decode::{LoadedBundle, LoadedPage};

/// Pages begin at multiples of this many words: 256 bytes.
pub(super) const GRANULE_WORDS: u32 = 64;
/// The weight of a page that answers alone. At a smaller weight, the next coarser level has the remainder.
pub(crate) const WHOLE: u32 = 256;
/// The most words of a write: 64 KiB, so that copying the remainder of a partly taken write is cheap. It is
/// even, because both words of a block are taken together.
const MAX_WRITE_WORDS: usize = 1 << 14;

/// Words that are to be written to the pool.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PoolWrite {
    /// The first word's place in the pool.
    pub at: u32,
    /// The words.
    pub words: Vec<u32>,
}

/// A level in use: its grid, and where its words are.
#[derive(Clone, Copy, Debug)]
pub(super) struct LevelPlaces {
    /// Its number in the file, 0 = the finest.
    pub(super) level: u32,
    pub(super) grid: LightGrid,
    pub(super) words: WordPlaces,
    /// Whether weights of its pages follow the table of blocks.
    pub(super) fades: bool,
}

/// The places of all parts of the pool.
#[derive(Debug)]
pub(super) struct PoolLayout {
    /// Levels in use, the finest first.
    pub(super) levels: Vec<LevelPlaces>,
    /// First word of the pages.
    pub(super) pages_at: u32,
    /// Number of words.
    pub(super) words: u32,
}

impl PoolLayout {
    /// Lays out the levels that a pool of `words` words can hold. If levels fade, all but the coarsest have
    /// weights.
    ///
    /// # Errors
    /// Returns the number of words that are needed, if not even the coarsest level fits.
    pub(super) fn new(contents: &Contents, options: &StreamOptions, words: u32) -> Result<Self, u64> {
        let StreamOptions { reserved_words, .. } = *options;
        let coarsest = contents.grids.len() - 1;
        let fades = |level: usize| options.fades() && level < coarsest;
        let pages: u64 = contents.tables[coarsest].iter().map(|entry| page_words(entry.raw_bytes)).sum();
        let [mut tables, mut commons] = [0_u64; 2];
        let mut used = 0;
        for (number, entry) in contents.grids.iter().enumerate().rev() {
            let [x, y] = block_dims(entry.grid.size, block_level(entry.grid.size)).map(u64::from);
            let weights = if fades(number) { page_count(entry.grid.size) } else { 0 };
            let (table, common) = (2 * x * y + weights, entry.common_raw_bytes / 4);
            let needed = u64::from(reserved_words) + tables + table + commons + common;
            // The coarsest must fit; each finer one must leave room for pages.
            let limit = if number == coarsest { words } else { words / 2 };
            let whole = needed.next_multiple_of(GRANULE_WORDS.into()) + pages;
            if whole > limit.into() {
                if number == coarsest {
                    return Err(whole);
                }
                break;
            }
            tables += table;
            commons += common;
            used += 1;
        }
        // All sums are below `words`, so they fit 32 bits.
        let mut at = reserved_words;
        let mut levels: Vec<LevelPlaces> = Vec::new();
        for (level, entry) in (0..).zip(&contents.grids).skip(contents.grids.len() - used) {
            let block_level = block_level(entry.grid.size);
            let block_dims = block_dims(entry.grid.size, block_level);
            let words = WordPlaces { block_level, block_dims, table_offset: at, code_offset: 0 };
            let fades = fades(level as usize);
            at += 2 * block_dims[0] * block_dims[1];
            if fades {
                at += page_count(entry.grid.size) as u32;
            }
            levels.push(LevelPlaces { level, grid: entry.grid, words, fades });
        }
        for places in &mut levels {
            places.words.code_offset = at;
            at += (contents.grids[places.level as usize].common_raw_bytes / 4) as u32;
        }
        Ok(Self { levels, pages_at: at.next_multiple_of(GRANULE_WORDS), words })
    }

    /// Returns the number of words for pages.
    pub(super) fn page_words(&self) -> u32 {
        self.words - self.pages_at
    }

    /// Returns the place of a level of the file in [`PoolLayout::levels`], if it is in use.
    pub(super) fn index_of(&self, level: u32) -> Option<usize> {
        level.checked_sub(self.levels.first()?.level).map(|i| i as usize).filter(|&i| i < self.levels.len())
    }
}

/// Returns the number of pages of a grid.
fn page_count(size: [u32; 3]) -> u64 {
    page_dims(size).map(u64::from).iter().product()
}

/// Returns about how many words of the pool a bundle takes: its words, and half a granule of padding per
/// page.
pub(super) fn page_words(raw_bytes: u32) -> u64 {
    if raw_bytes == 0 {
        return 0;
    }
    let words = u64::from(raw_bytes / 4) - HEAD_WORDS as u64;
    words + u64::from(GRANULE_WORDS / 2) * (HEAD_WORDS as u64 / 3)
}

impl LevelPlaces {
    /// Returns the level's quadtree in the words of the pool.
    pub(super) fn tree<'w>(&self, words: &'w [u32]) -> TreeWords<'w> {
        let WordPlaces { block_level, block_dims, table_offset, code_offset } = self.words;
        let blocks = block_dims.iter().map(|&n| n as usize).product::<usize>();
        TreeWords {
            size: self.grid.size,
            block_level,
            block_dims,
            blocks: &words[table_offset as usize..].as_chunks().0[..blocks],
            code: &words[code_offset as usize..],
        }
    }

    /// Returns the weight of this level's answer for a filter over columns low…high of the grid: the smallest
    /// weight of their pages. `words` are those of the pool.
    pub(super) fn weight(&self, words: &[u32], low: [u32; 2], high: [u32; 2]) -> u32 {
        if !self.fades {
            return WHOLE;
        }
        let [low, high] = [low, high].map(|column| column.map(|c| c >> PAGE_LEVEL));
        let (across, at) = (page_dims(self.grid.size)[0], self.weights_at());
        let pages = (low[1]..=high[1]).flat_map(|y| (low[0]..=high[0]).map(move |x| y * across + x));
        pages.map(|page| words[(at + page) as usize]).fold(WHOLE, u32::min)
    }

    /// Returns the word of the first page's weight.
    fn weights_at(&self) -> u32 {
        let WordPlaces { block_dims: [x, y], table_offset, .. } = self.words;
        table_offset + 2 * x * y
    }

    /// Writes the blocks of a page: those of each row that are in the grid.
    fn put_blocks(
        &self,
        [x, y]: [u32; 2],
        block: impl Fn(usize) -> [u32; 2],
        put: &mut impl FnMut(PoolWrite),
    ) {
        let WordPlaces { block_level, block_dims: [across, down], table_offset, .. } = self.words;
        let side = 1 << (PAGE_LEVEL - block_level);
        let columns = side.min(across - x * side);
        for row in 0..side.min(down - y * side) {
            let at = table_offset + 2 * ((y * side + row) * across + x * side);
            let words = (0..columns).flat_map(|column| block((row * side + column) as usize)).collect();
            put(PoolWrite { at, words });
        }
    }
}

/// The words of a pool that pages occupy, and the queue of writes.
#[derive(Debug)]
pub(super) struct Pool {
    /// In granules.
    free: RangeAllocator<u32>,
    free_granules: u32,
    queue: VecDeque<PoolWrite>,
    queued_words: usize,
    /// Weights, which are written before the queue.
    weights: VecDeque<PoolWrite>,
    /// Number of writes that have been put into the queue, and taken from it.
    put_writes: u64,
    taken_writes: u64,
}

/// The pages of a resident bundle, by place, each with its granules.
#[derive(Debug)]
pub(super) struct PlacedPages(Vec<([u32; 2], Range<u32>)>);

impl PlacedPages {
    /// Returns the number of words that the pages take.
    pub(super) fn words(&self) -> u32 {
        self.0.iter().map(|(_, range)| GRANULE_WORDS * (range.end - range.start)).sum()
    }

    /// Returns the number of words that the pages of a bundle will take.
    pub(super) fn words_of(bundle: &LoadedBundle) -> u32 {
        bundle.pages.iter().map(|page| (page.words.len() as u32).next_multiple_of(GRANULE_WORDS)).sum()
    }
}

impl Pool {
    /// Makes an empty pool, and writes the tables: bundles without bytes are resident, others are not.
    pub(super) fn new(layout: &PoolLayout, contents: &Contents) -> Self {
        let granules = layout.page_words() / GRANULE_WORDS;
        let mut pool = Self {
            // The allocator does not take an empty range.
            free: RangeAllocator::new(0..granules.max(1)),
            free_granules: granules,
            queue: VecDeque::new(),
            queued_words: 0,
            weights: VecDeque::new(),
            put_writes: 0,
            taken_writes: 0,
        };
        for places in &layout.levels {
            let WordPlaces { block_dims, table_offset, .. } = places.words;
            let mut table = vec![[ABSENT, 0]; block_dims.iter().map(|&n| n as usize).product()];
            let dims = page_dims(places.grid.size);
            let mut weights = vec![0; if places.fades { page_count(places.grid.size) as usize } else { 0 }];
            let entries = &contents.tables[places.level as usize];
            for (bundle, entry) in bundles(dims).into_iter().zip(entries) {
                if entry.stored_bytes != 0 {
                    continue;
                }
                let block = |_| [UNIFORM, entry.range.nearest];
                for place in pages_of(bundle, dims).into_iter().flatten() {
                    if places.fades {
                        weights[(place[1] * dims[0] + place[0]) as usize] = WHOLE;
                    }
                    places.put_blocks(place, block, &mut |write: PoolWrite| {
                        let first = (write.at - table_offset) as usize / 2;
                        let blocks = write.words.as_chunks().0;
                        table[first..first + blocks.len()].copy_from_slice(blocks);
                    });
                }
            }
            let words = [table.into_flattened(), weights].concat();
            pool.put(PoolWrite { at: table_offset, words });
        }
        pool
    }

    /// Sets the weight of all pages of a resident bundle.
    pub(super) fn put_weight(&mut self, places: &LevelPlaces, pages: &PlacedPages, weight: u32) {
        let place = |axis: usize| pages.0.iter().map(move |(place, _)| place[axis]);
        let (Some(low), Some(high)) = (place(0).min(), place(0).max()) else { return };
        let (Some(first), Some(last)) = (place(1).min(), place(1).max()) else { return };
        let across = page_dims(places.grid.size)[0];
        for y in first..=last {
            let words = vec![weight; (high - low + 1) as usize];
            self.queued_words += words.len();
            self.weights.push_back(PoolWrite { at: places.weights_at() + y * across + low, words });
        }
    }

    /// Writes the common section of a level.
    pub(super) fn put_common(&mut self, places: &LevelPlaces, words: &[u32]) {
        if !words.is_empty() {
            self.put(PoolWrite { at: places.words.code_offset, words: words.to_vec() });
        }
    }

    /// Makes a bundle resident, and takes its pages' words. Returns `None`, with nothing changed, if there is
    /// no room.
    pub(super) fn place(
        &mut self,
        layout: &PoolLayout,
        places: &LevelPlaces,
        bundle: &mut LoadedBundle,
    ) -> Option<PlacedPages> {
        let mut placed = Vec::with_capacity(bundle.pages.len());
        for page in &bundle.pages {
            let granules = (page.words.len() as u32).div_ceil(GRANULE_WORDS);
            let range = if granules == 0 { Some(0..0) } else { self.allocate(granules) };
            let Some(range) = range else {
                self.free(&PlacedPages(placed));
                return None;
            };
            placed.push((page.place, range));
        }
        let word = |range: &Range<u32>| layout.pages_at + GRANULE_WORDS * range.start;
        for (page, (_, range)) in bundle.pages.iter_mut().zip(&placed) {
            if !page.words.is_empty() {
                self.put(PoolWrite { at: word(range), words: std::mem::take(&mut page.words) });
            }
        }
        for (LoadedPage { place, blocks, .. }, (_, range)) in bundle.pages.iter().zip(&placed) {
            let behind = word(range) - places.words.code_offset;
            let block = |i: usize| [Page::address(blocks[i][0], behind), blocks[i][1]];
            places.put_blocks(*place, block, &mut |write| self.put(write));
        }
        Some(PlacedPages(placed))
    }

    /// Removes a bundle, and frees its words.
    pub(super) fn remove(&mut self, places: &LevelPlaces, pages: &PlacedPages) {
        for (place, _) in &pages.0 {
            places.put_blocks(*place, |_| [ABSENT, 0], &mut |write| self.put(write));
        }
        self.free(pages);
    }

    fn allocate(&mut self, granules: u32) -> Option<Range<u32>> {
        if granules > self.free_granules {
            return None;
        }
        let range = self.free.allocate_range(granules).ok()?;
        self.free_granules -= granules;
        Some(range)
    }

    fn free(&mut self, pages: &PlacedPages) {
        for (_, range) in pages.0.iter().filter(|(_, range)| !range.is_empty()) {
            self.free_granules += range.end - range.start;
            self.free.free_range(range.clone());
        }
    }

    fn put(&mut self, write: PoolWrite) {
        self.queued_words += write.words.len();
        self.put_writes += write.words.chunks(MAX_WRITE_WORDS).len() as u64;
        if write.words.len() <= MAX_WRITE_WORDS {
            self.queue.push_back(write);
            return;
        }
        for (i, words) in write.words.chunks(MAX_WRITE_WORDS).enumerate() {
            let at = write.at + (i * MAX_WRITE_WORDS) as u32;
            self.queue.push_back(PoolWrite { at, words: words.to_vec() });
        }
    }

    /// Returns the number of words that are still to be written.
    pub(super) fn queued_words(&self) -> usize {
        self.queued_words
    }

    /// Returns the number of writes, without weights, that have been put into the queue.
    pub(super) fn put_writes(&self) -> u64 {
        self.put_writes
    }

    /// Returns the number of writes, without weights, that have been taken.
    pub(super) fn taken_writes(&self) -> u64 {
        self.taken_writes
    }

    /// Returns the number of words that no page occupies.
    pub(super) fn free_words(&self) -> u32 {
        GRANULE_WORDS * self.free_granules
    }

    /// Takes the next writes, of at most `max_words` words. Both words of a block are taken together.
    pub(super) fn take(&mut self, max_words: usize) -> Vec<PoolWrite> {
        let mut taken = Vec::new();
        let mut left = max_words & !1;
        while left > 0
            && let Some(write) = self.weights.pop_front_if(|write| write.words.len() <= left)
        {
            left = left.saturating_sub(write.words.len().next_multiple_of(2));
            self.queued_words -= write.words.len();
            taken.push(write);
        }
        while left > 0
            && let Some(mut write) = self.queue.pop_front()
        {
            if write.words.len() > left {
                let rest = write.words.split_off(left);
                self.queue.push_front(PoolWrite { at: write.at + left as u32, words: rest });
            } else {
                self.taken_writes += 1;
            }
            left = left.saturating_sub(write.words.len().next_multiple_of(2));
            self.queued_words -= write.words.len();
            taken.push(write);
        }
        taken
    }
}
