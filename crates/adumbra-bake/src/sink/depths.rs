//! Builds a quadtree of depths from blocks of columns, bottom up.
//!
//! A root's shapes depend on its columns alone, so a finished root becomes a page at once, and neither the
//! number of threads nor their order matters. Root blocks that are smaller than pages wait for the other
//! blocks of their page.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};

use crate::cache::PartCache;
use crate::columns::BlockColumns;
use crate::pages::{self, OwnedPage, PageStore, Pages, Spill};
use crate::sink::recent::RecentOfLevel;
use crate::sink::undecided::Undecided;
use crate::sink::{BlockSink, HELD_LEAF_BYTES, Structure};
use adumbra::layout::depths::page::{BUNDLE_SIDE, PAGE_LEVEL, page_dims};
use adumbra::layout::depths::shapes::ShapeSet;
use adumbra::layout::depths::{LEAF_LEVEL, NEVER, NODE_LEVELS, UNIFORM};

/// Number of half-words above which no more roots are accepted.
const MAX_HALVES: u64 = (1 << 32) - (1 << 28);

/// Builds the pages of a quadtree of depths from blocks.
pub struct DepthsSink {
    size: [u32; 3],
    /// Level of the bake's own root blocks.
    level: u32,
    /// Whether equal shapes are stored once.
    merged: bool,
    /// The processor's vectors.
    arch: pulp::Arch,
    store: PageStore,
    /// Number in the store, or [`UNIFORM`], and base of each page, x fastest.
    places: Mutex<Vec<[u32; 2]>>,
    /// Bytes of the pages of each bundle so far, and of the fullest one.
    bundle_bytes: Mutex<HashMap<[u32; 2], u64>>,
    fullest_bundle_bytes: AtomicU64,
    /// Root blocks that are smaller than their pages, by page.
    waiting: Mutex<HashMap<[u32; 2], Waiting>>,
    waiting_leaves: AtomicU64,
    /// Whether there was a page beyond the reach of pointers.
    is_too_large: AtomicBool,
    /// Memory that workers reuse.
    drafts: Mutex<Vec<ShapeSet>>,
    /// The entries of the bake.
    cache: Option<PartCache>,
    /// Whether pages are needed after their entries have been written.
    links: bool,
    /// The root blocks of earlier bakes, where they are smaller than pages.
    recent: Option<RecentOfLevel<DepthsBlock>>,
}

/// The root blocks of a page that are done.
struct Waiting {
    /// In rows of [`DepthsSink::blocks_across`].
    blocks: Vec<Option<DepthsBlock>>,
    /// Number of blocks inside the grid that are not done.
    missing: usize,
}

/// A finished block.
#[derive(Clone)]
pub struct DepthsBlock(BlockContent);

#[derive(Clone)]
enum BlockContent {
    /// The whole block, at a level that nodes have, or uniform at any level.
    One(Undecided),
    /// Four quarters, at a level between two node levels.
    Four(Box<[Undecided; 4]>),
    /// At the pages' level and above: number and base of each page, in the order of quarters at every level.
    Pages(Vec<[u32; 2]>),
    /// A root block that the sink has taken.
    Taken,
}

impl DepthsBlock {
    /// Returns a block below the roots whose level nodes have.
    fn whole(self) -> Undecided {
        match self.0 {
            BlockContent::One(block) => block,
            BlockContent::Four(_) | BlockContent::Pages(_) | BlockContent::Taken => {
                unreachable!("only levels between node levels are held in quarters")
            }
        }
    }

    /// Returns the quarters of a block below the roots whose level is between those of nodes.
    fn quarters(self) -> [Undecided; 4] {
        match self.0 {
            BlockContent::Four(quarters) => *quarters,
            BlockContent::One(all) => [all.base; 4].map(Undecided::uniform),
            BlockContent::Pages(_) | BlockContent::Taken => unreachable!("pages are not quarters of nodes"),
        }
    }
}

/// Returns the bytes that this many finished root blocks of `level` take, apart from the pages' words.
pub(crate) fn top_bytes(blocks: u64, level: u32) -> u64 {
    let pages = blocks << (2 * level.saturating_sub(PAGE_LEVEL));
    // Number and base of each page, in its block and in the grid.
    blocks * size_of::<DepthsBlock>() as u64 + 2 * pages * size_of::<[u32; 2]>() as u64
}

fn lock<T>(slot: &Mutex<T>) -> MutexGuard<'_, T> {
    slot.lock().unwrap_or_else(|e| e.into_inner())
}

impl DepthsSink {
    /// Creates a sink in memory for a grid of `size` voxels along x, y, z, and a bake whose own roots have
    /// `level`, at least 3. `merged`: equal shapes are stored once, as in every file.
    pub fn in_memory(size: [u32; 3], level: u32, merged: bool) -> Self {
        Self::new(size, level, merged, &Arc::new(Spill::unlimited()))
    }

    /// Creates a sink whose pages go to `spill`. See [`DepthsSink::in_memory`].
    pub(crate) fn new(size: [u32; 3], level: u32, merged: bool, spill: &Arc<Spill>) -> Self {
        let pages = page_dims(size).map(|n| n as usize).iter().product();
        Self {
            size,
            level,
            merged,
            arch: pulp::Arch::new(),
            store: PageStore::new(Arc::clone(spill)),
            places: Mutex::new(vec![[UNIFORM, NEVER]; pages]),
            bundle_bytes: Mutex::default(),
            fullest_bundle_bytes: AtomicU64::new(0),
            waiting: Mutex::default(),
            waiting_leaves: AtomicU64::new(0),
            is_too_large: AtomicBool::new(false),
            drafts: Mutex::default(),
            cache: None,
            links: true,
            recent: None,
        }
    }

    /// Takes the pages of all entries that the cache has. Missing entries are written as soon as their parts
    /// are done.
    pub(crate) fn with_cache(mut self, cache: PartCache) -> Self {
        cache.find(|part, pages| {
            for (place, OwnedPage { root, base, words }) in cache.parts.pages(part).zip(pages) {
                let number = if root == UNIFORM { UNIFORM } else { self.store.add(root, words) };
                self.put(place, [number, base]);
            }
        });
        self.cache = Some(cache);
        self
    }

    /// Makes the sink write the missing entries, and nothing else.
    pub(crate) fn for_entries_alone(mut self, cache: PartCache) -> Self {
        cache.find(|_, _| {});
        (self.cache, self.links) = (Some(cache), false);
        self
    }

    /// Reuses the root blocks that earlier bakes have built from the same inputs, and keeps those that this
    /// bake builds.
    pub(crate) fn with_recent(mut self, recent: RecentOfLevel<DepthsBlock>) -> Self {
        self.recent = Some(recent);
        self
    }

    /// Whether the entry of a part was found.
    pub(crate) fn has_part(&self, part: usize) -> bool {
        self.cache.as_ref().is_some_and(|cache| cache.has(part))
    }

    /// Returns the number of entries that were left out, and the room that the longest of them would have
    /// needed.
    pub(crate) fn left_out(&self) -> (usize, u64) {
        self.cache.as_ref().map_or((0, 0), PartCache::left_out)
    }

    /// Returns the number of root blocks whose entries were found.
    pub(crate) fn found_root_blocks(&self) -> usize {
        self.cache.as_ref().map_or(0, PartCache::found_root_blocks)
    }

    /// Writes the entry of the part at a page, which is done.
    fn write_entry(&self, page: [u32; 2]) {
        let Some(cache) = &self.cache else { return };
        let part = cache.parts.at_page(page);
        let across = page_dims(self.size)[0];
        let pages: Vec<[u32; 2]> = {
            let places = lock(&self.places);
            cache.parts.pages(part).map(|[x, y]| places[(y * across + x) as usize]).collect()
        };
        let contents: Option<Vec<_>> = pages
            .iter()
            .map(|&[number, base]| {
                if number == UNIFORM {
                    return Some((UNIFORM, base, Arc::from([])));
                }
                // The spill has recorded a lost page as an error.
                self.store.get(number).map(|(words, root)| (root, base, words))
            })
            .collect();
        if let Some(contents) = contents {
            cache.put(part, contents.iter().map(|(root, base, words)| (*root, *base, &**words)));
        }
        if !self.links {
            pages.iter().filter(|page| page[0] != UNIFORM).for_each(|page| self.store.forget(page[0]));
        }
    }

    /// Whether blocks of this level are nodes or leaves.
    fn is_node_level(level: u32) -> bool {
        (level - LEAF_LEVEL).is_multiple_of(NODE_LEVELS)
    }

    /// Makes a page of a block, and returns its number and base.
    fn page(&self, block: &Undecided) -> [u32; 2] {
        if block.is_endless() {
            return [UNIFORM, NEVER];
        }
        let base = block.base[0];
        let mut draft = lock(&self.drafts).pop().unwrap_or_else(|| ShapeSet::new(self.merged));
        draft.clear();
        let is_uniform = block.draft(base, PAGE_LEVEL, &mut draft).is_none();
        let number = if is_uniform {
            UNIFORM
        } else {
            // A page that is too large is reported as an error when the next root block is done, and at the
            // end.
            pages::page(draft.list()).map_or_else(
                |_| {
                    self.is_too_large.store(true, Ordering::Relaxed);
                    UNIFORM
                },
                |(words, root)| self.store.add(root, words),
            )
        };
        lock(&self.drafts).push(draft);
        [number, base]
    }

    /// Returns the pages of a block of `level`, which is at least the pages' own.
    fn pages(&self, level: u32, block: DepthsBlock) -> Vec<[u32; 2]> {
        match block.0 {
            BlockContent::Pages(pages) => pages,
            BlockContent::One(all) => vec![self.page(&all); 1 << (2 * (level - PAGE_LEVEL))],
            BlockContent::Four(quarters) => quarters.iter().map(|q| self.page(q)).collect(),
            BlockContent::Taken => unreachable!("it has been taken"),
        }
    }

    /// Wraps a block. Pages are made at once.
    fn resolve(&self, level: u32, block: Undecided) -> DepthsBlock {
        DepthsBlock(if level == PAGE_LEVEL {
            BlockContent::Pages(vec![self.page(&block)])
        } else {
            BlockContent::One(block)
        })
    }

    /// Returns the number of root blocks along a side of a page, if they are smaller than pages.
    fn blocks_across(&self) -> u32 {
        1 << PAGE_LEVEL.saturating_sub(self.level)
    }

    /// Takes a root block that is smaller than a page, and makes the page if it was the last one missing.
    fn take_small(&self, [x, y]: [u32; 2], block: DepthsBlock) {
        let across = self.blocks_across();
        let page = [x / across, y / across];
        let leaves = |block: &DepthsBlock| match &block.0 {
            BlockContent::One(block) => block.leaves(),
            BlockContent::Four(quarters) => quarters.iter().map(Undecided::leaves).sum(),
            BlockContent::Pages(_) | BlockContent::Taken => 0,
        };
        self.waiting_leaves.fetch_add(leaves(&block), Ordering::Relaxed);
        let blocks = {
            let mut waiting = lock(&self.waiting);
            let here = waiting.entry(page).or_insert_with(|| {
                // Pages at the grid's end have fewer blocks.
                let inside = [0, 1].map(|a| {
                    (self.size[a].div_ceil(1 << self.level) - page[a] * across).min(across) as usize
                });
                let blocks = (0..across * across).map(|_| None).collect();
                Waiting { blocks, missing: inside[0] * inside[1] }
            });
            here.blocks[(y % across * across + x % across) as usize] = Some(block);
            here.missing -= 1;
            if here.missing > 0 {
                return;
            }
            waiting.remove(&page).map(|here| here.blocks).unwrap_or_default()
        };
        let done: u64 = blocks.iter().flatten().map(leaves).sum();
        let mut blocks = blocks;
        let whole = self.joined(&mut blocks, PAGE_LEVEL, [0, 0]);
        self.waiting_leaves.fetch_sub(done, Ordering::Relaxed);
        self.put(page, self.pages(PAGE_LEVEL, whole)[0]);
        self.write_entry(page);
    }

    /// Joins the root blocks of a page's part of `level` that begins at this block.
    fn joined(&self, blocks: &mut [Option<DepthsBlock>], level: u32, [x, y]: [u32; 2]) -> DepthsBlock {
        if level == self.level {
            let block = blocks[(y * self.blocks_across() + x) as usize].take();
            return block.unwrap_or(DepthsBlock(BlockContent::One(Undecided::free())));
        }
        let half = 1 << (level - 1 - self.level);
        let quarters =
            [0, 1, 2, 3].map(|q| self.joined(blocks, level - 1, [x + (q >> 1) * half, y + (q & 1) * half]));
        self.join(level, quarters)
    }

    /// Returns the place of a root block in the grid, in root blocks.
    fn place(&self, number: usize) -> [u32; 2] {
        let across = self.size[0].div_ceil(1 << self.level);
        [number as u32 % across, number as u32 / across]
    }

    fn put(&self, [x, y]: [u32; 2], page: [u32; 2]) {
        let dims = page_dims(self.size);
        if x >= dims[0] || y >= dims[1] {
            return;
        }
        lock(&self.places)[(y * dims[0] + x) as usize] = page;
        if page[0] != UNIFORM {
            let mut bundles = lock(&self.bundle_bytes);
            let bundle = bundles.entry([x, y].map(|n| n / BUNDLE_SIDE)).or_default();
            *bundle += self.store.page_bytes(page[0]);
            self.fullest_bundle_bytes.fetch_max(*bundle, Ordering::Relaxed);
        }
    }

    /// Returns the pages for a file. All root blocks must have been taken.
    pub(crate) fn into_pages(self) -> Pages {
        let places = self.places.into_inner().unwrap_or_else(|e| e.into_inner());
        let is_too_large = self.is_too_large.into_inner();
        Pages { size: self.size, places, store: self.store, merged: self.merged, is_too_large }
    }
}

impl BlockSink for DepthsSink {
    type Block = DepthsBlock;

    fn uniform(&self, level: u32, interval: [u32; 2]) -> DepthsBlock {
        let block = Undecided::uniform(interval);
        if level > PAGE_LEVEL {
            let pages = 1 << (2 * (level - PAGE_LEVEL));
            return DepthsBlock(BlockContent::Pages(vec![self.page(&block); pages]));
        }
        self.resolve(level, block)
    }

    #[inline(never)] // Counted by `cargo xtask count`.
    fn leaf(&self, columns: &BlockColumns) -> DepthsBlock {
        self.resolve(LEAF_LEVEL, Undecided::leaf(columns, self.arch))
    }

    fn join(&self, level: u32, quarters: [DepthsBlock; 4]) -> DepthsBlock {
        if level > PAGE_LEVEL {
            let pages = quarters.into_iter().flat_map(|q| self.pages(level - 1, q)).collect();
            return DepthsBlock(BlockContent::Pages(pages));
        }
        if !Self::is_node_level(level) {
            return DepthsBlock(BlockContent::Four(Box::new(quarters.map(DepthsBlock::whole))));
        }
        let mut children: [Undecided; 16] = std::array::from_fn(|_| Undecided::free());
        for (quarter, block) in quarters.into_iter().enumerate() {
            for (part, block) in block.quarters().into_iter().enumerate() {
                let (x, y) = ((quarter >> 1) * 2 + (part >> 1), (quarter & 1) * 2 + (part & 1));
                children[y * 4 + x] = block;
            }
        }
        self.resolve(level, Undecided::over(children))
    }

    fn known(&self, number: usize) -> Option<DepthsBlock> {
        if self.cache.as_ref().is_some_and(|cache| cache.has(cache.parts.of_root_block(number))) {
            return Some(DepthsBlock(BlockContent::Taken));
        }
        let block = self.recent.as_ref()?.get(number)?;
        self.take_small(self.place(number), block);
        Some(DepthsBlock(BlockContent::Taken))
    }

    fn taken(&self, block: usize, made: DepthsBlock) -> DepthsBlock {
        if matches!(made.0, BlockContent::Taken) {
            return made;
        }
        let place = self.place(block);
        if self.level < PAGE_LEVEL {
            if let Some(recent) = &self.recent {
                recent.put(block, &made);
            }
            self.take_small(place, made);
        } else {
            let side = self.level - PAGE_LEVEL;
            for (number, page) in (0_u32..).zip(self.pages(self.level, made)) {
                // Quarters are numbered x_bit << 1 | y_bit at every level.
                let bits = |shift: u32| (0..side).fold(0, |c, l| c | (number >> (2 * l + shift) & 1) << l);
                self.put([(place[0] << side) + bits(1), (place[1] << side) + bits(0)], page);
            }
            self.write_entry(place.map(|n| n << side));
        }
        DepthsBlock(BlockContent::Taken)
    }
}

impl Structure for DepthsSink {
    type Output = Pages;
    const SO_FAR: &'static str = "the depths so far";
    const FINISHING: &'static str = "linking the pages";

    fn memory_bytes(&self) -> u64 {
        self.store.table_bytes() + self.waiting_leaves.load(Ordering::Relaxed) * HELD_LEAF_BYTES
    }

    fn result_bytes(&self) -> u64 {
        2 * self.store.halves()
    }

    fn finish_bytes(&self) -> u64 {
        Pages::link_bytes(&self.store, self.fullest_bundle_bytes.load(Ordering::Relaxed))
    }

    fn check_room(&self) -> Result<(), crate::Error> {
        if self.is_too_large.load(Ordering::Relaxed) || self.store.halves() > MAX_HALVES {
            return Err(crate::Error::TooManyWords { what: "the quadtree of depths" });
        }
        self.cache.as_ref().map_or(Ok(()), PartCache::check)
    }

    fn make_room(&self) {
        self.store.shrink();
    }

    fn finish(self, blocks: Vec<DepthsBlock>) -> Pages {
        for (number, block) in blocks.into_iter().enumerate() {
            self.taken(number, block);
        }
        self.into_pages()
    }
}
