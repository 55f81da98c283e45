//! An open file: its chosen bundles, and the next requests.

use std::collections::HashMap;
use std::sync::Arc;

use crate::file::{BundleEntry, Contents, GridEntry, LEVEL_STEP};
use crate::layout::depths::page::{BUNDLE_SIDE, bundles, page_dims};
use crate::layout::depths::top::{block_dims, block_level};
use crate::stream::choose::Candidates;
use crate::stream::decode::{LevelContext, Stored};
use crate::stream::opening::OpenedFile;
use crate::stream::options::StreamOptions;
use crate::stream::pool::{PoolLayout, page_words};
use crate::stream::request::{Job, Request};
use crate::stream::residents::Residents;
use crate::stream::retry::{BundleId, Part};
use crate::stream::{StreamError, View};

/// Bytes of a request for several bundles.
const MAX_REQUEST_BYTES: u64 = 1 << 18;
/// Nothing more is requested while more words than this wait to be written.
const MAX_QUEUED_WORDS: usize = 1 << 20;
/// Nothing more is requested while more bundles than this wait for room.
const MAX_WAITING: usize = 32;

/// An open file.
#[derive(Debug)]
pub(super) struct Open {
    pub(super) contents: Contents,
    pub(super) layout: Arc<PoolLayout>,
    pub(super) residents: Residents,
    /// Levels in use, in the order of [`PoolLayout::levels`].
    levels: Vec<Level>,
    pub(super) views: Vec<View>,
    /// Chosen bundles, the most urgent first.
    pub(super) chosen: Vec<BundleId>,
    /// See [`StreamCounts::decoded_bytes`].
    pub(super) decoded_bytes: u64,
    /// Words for pages of all levels but the coarsest.
    room_words: u64,
}

/// A level in use.
#[derive(Debug)]
pub(super) struct Level {
    context: Option<Arc<LevelContext>>,
    /// Bundles along x and y.
    dims: [u32; 2],
    /// Places of bundles, in file order, and their order by place, x fastest.
    places: Vec<[u32; 2]>,
    order: Vec<u32>,
    /// Offset of each bundle in the file.
    offsets: Vec<u64>,
}

impl Level {
    fn index_of(&self, [x, y]: [u32; 2]) -> u32 {
        self.order[(y * self.dims[0] + x) as usize]
    }
}

impl Open {
    /// Lays everything out in a pool, and makes the coarsest level resident.
    pub(super) fn new(file: OpenedFile, options: &StreamOptions, words: u32) -> Result<Self, StreamError> {
        let OpenedFile { contents, coarsest, bundles: mut loaded } = file;
        let layout = PoolLayout::new(&contents, options, words)
            .map_err(|needed| StreamError::Budget { needed: 4 * needed, budget: options.budget_bytes })?;
        let layout = Arc::new(layout);
        let mut residents = Residents::new(Arc::clone(&layout), &contents, options.fade_frames);
        let levels = layout.levels.iter().map(|places| {
            let number = places.level as usize;
            let dims = page_dims(places.grid.size);
            let places = bundles(dims);
            let dims = dims.map(|n| n.div_ceil(BUNDLE_SIDE));
            let mut order = vec![0; places.len()];
            for (index, [x, y]) in (0..).zip(&places) {
                order[(y * dims[0] + x) as usize] = index;
            }
            let mut end = contents.grids[number].bundles.offset;
            let offset = |entry: &BundleEntry| {
                let offset = end;
                end += u64::from(entry.stored_bytes);
                offset
            };
            let offsets = contents.tables[number].iter().map(offset).collect();
            Level { context: None, dims, places, order, offsets }
        });
        let mut levels: Vec<Level> = levels.collect();
        if let (Some(places), Some(level)) = (layout.levels.last(), levels.last_mut()) {
            let pool = &mut residents.pool;
            pool.put_common(places, coarsest.common.words());
            for bundle in &mut loaded {
                // Half a granule of padding per page was counted, but a page may need more.
                if pool.place(&layout, places, bundle).is_none() {
                    let needed = 4 * (u64::from(words) + 1);
                    return Err(StreamError::Budget { needed, budget: options.budget_bytes });
                }
            }
            level.context = Some(coarsest);
        }
        // A tenth is left for the gaps between pages. The coarsest level, which stays, keeps its share.
        let of_coarsest = contents.tables.last().map_or(0, |table| words_of(table));
        let room_words = (u64::from(layout.page_words()) * 9 / 10).saturating_sub(of_coarsest);
        Ok(Self {
            decoded_bytes: decoded_bytes(&contents),
            room_words,
            contents,
            layout,
            residents,
            levels,
            views: Vec::new(),
            chosen: Vec::new(),
        })
    }

    fn entry(&self, id: BundleId) -> &BundleEntry {
        &self.contents.tables[id.level as usize][id.index as usize]
    }

    /// Chooses bundles for these views.
    pub(super) fn choose(&mut self, views: &[View], options: &StreamOptions) {
        let mut needs: HashMap<BundleId, f64> = HashMap::new();
        for (places, level) in self.layout.levels.iter().zip(&self.levels).rev().skip(1) {
            let number = places.level;
            let table = &self.contents.tables[number as usize];
            let coarser = f64::from(LEVEL_STEP) * places.grid.voxel_size;
            let candidates =
                Candidates { grid: &places.grid, coarser_texel_world: coarser, dims: level.dims };
            let nearest = |place| {
                let entry = &table[level.index_of(place) as usize];
                (entry.stored_bytes != 0).then_some(entry.range.nearest)
            };
            for view in views {
                candidates.each(view, options.detail_pixels, nearest, |place, need| {
                    let known = needs.entry(BundleId { level: number, index: level.index_of(place) });
                    let known = known.or_insert(need);
                    *known = known.max(need);
                });
            }
        }
        let mut wanted: Vec<(BundleId, f64)> = needs.into_iter().collect();
        wanted.sort_by(|(a, need_a), (b, need_b)| {
            need_b.total_cmp(need_a).then(b.level.cmp(&a.level)).then(a.index.cmp(&b.index))
        });
        let mut left = self.room_words;
        self.chosen.clear();
        for (id, _) in wanted {
            let words = page_words(self.entry(id).raw_bytes);
            if words > left {
                break;
            }
            left -= words;
            self.chosen.push(id);
        }
        self.residents.choose(self.chosen.iter().copied().collect());
        self.views = views.to_vec();
    }

    /// Returns the most urgent request for chosen bundles that are not resident.
    pub(super) fn next_request(&self, may_ask: impl Fn(Part) -> bool) -> Option<Request> {
        if self.residents.pool.queued_words() > MAX_QUEUED_WORDS || self.residents.waiting() > MAX_WAITING {
            return None;
        }
        let is_missing = |id: BundleId| self.residents.is_missing(id) && may_ask(Part::Bundle(id));
        for &id in &self.chosen {
            if !is_missing(id) {
                continue;
            }
            let level = &self.levels[self.layout.index_of(id.level)?];
            let Some(context) = &level.context else {
                if !may_ask(Part::Common { level: id.level }) {
                    continue;
                }
                let entry = self.contents.grids[id.level as usize];
                let range = entry.common.offset..entry.common.end();
                let encoding = self.contents.header.encoding;
                return Some(Request {
                    range,
                    job: Job::Common { entry: Box::new(entry), encoding, level: id.level },
                });
            };
            return Some(self.request_along(level, context, id, is_missing));
        }
        None
    }

    /// Returns a request for a bundle, and for its neighbours in the file that are missing too.
    fn request_along(
        &self,
        level: &Level,
        context: &Arc<LevelContext>,
        id: BundleId,
        is_missing: impl Fn(BundleId) -> bool,
    ) -> Request {
        let table = &self.contents.tables[id.level as usize];
        let stored_bytes = |index: u32| u64::from(table[index as usize].stored_bytes);
        let mut bytes = stored_bytes(id.index);
        let mut take = |index: u32| {
            let is_empty = stored_bytes(index) == 0;
            let takes = is_empty || is_missing(BundleId { index, ..id });
            if !takes || bytes + stored_bytes(index) > MAX_REQUEST_BYTES {
                return false;
            }
            bytes += stored_bytes(index);
            true
        };
        let (mut first, mut last) = (id.index, id.index);
        while first > 0 && take(first - 1) {
            first -= 1;
        }
        while (last as usize) + 1 < table.len() && take(last + 1) {
            last += 1;
        }
        let start = level.offsets[first as usize];
        let bundles = (first..=last).filter(|&index| stored_bytes(index) != 0).map(|index| Stored {
            index,
            place: level.places[index as usize],
            entry: table[index as usize],
            offset: (level.offsets[index as usize] - start) as usize,
        });
        let job = Job::Bundles { context: Arc::clone(context), bundles: bundles.collect() };
        Request { range: start..start + bytes, job }
    }

    pub(super) fn add_common(&mut self, context: Arc<LevelContext>) {
        let Some(i) = self.layout.index_of(context.level) else { return };
        self.residents.pool.put_common(&self.layout.levels[i], context.common.words());
        self.levels[i].context = Some(context);
    }
}

/// Returns the bytes of the words of all levels.
fn decoded_bytes(contents: &Contents) -> u64 {
    let of_level = |(grid, table): (&GridEntry, &Vec<BundleEntry>)| {
        let blocks = block_dims(grid.grid.size, block_level(grid.grid.size)).map(u64::from);
        grid.common_raw_bytes + 4 * words_of(table) + 8 * blocks[0] * blocks[1]
    };
    contents.grids.iter().zip(&contents.tables).map(of_level).sum()
}

/// Returns about how many words of a pool all bundles of a level take.
fn words_of(table: &[BundleEntry]) -> u64 {
    table.iter().map(|entry| page_words(entry.raw_bytes)).sum()
}
