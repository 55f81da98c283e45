//! A stream without threads: requests, answers, faults and writes.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Duration;

use crate::error::Result;
use crate::gpu::{Bindings, LookUp, Parameters, middle, of_stream, put_header};
use crate::grid::LightGrid;
use crate::query::Filter;
use crate::settings::FileSettings;
use crate::stream::open::Open;
use crate::stream::opening::{Beginning, Opened};
use crate::stream::options::{StreamCounts, StreamOptions};
use crate::stream::pool::LevelPlaces;
use crate::stream::request::{Answer, Job, Loaded, Request};
use crate::stream::retry::{BundleId, Part, Retries};
use crate::stream::{PoolSampler, PoolWrite, StreamError, StreamFault, View};

/// Requests that may be under way at a time.
const MAX_REQUESTS: usize = 6;
/// A file that is read where views need it. It returns requests for bytes, takes their answers, and returns
/// writes to a pool of words. It neither reads nor decodes, so it never blocks.
#[derive(Debug)]
pub struct Resident {
    options: StreamOptions,
    state: State,
    /// Parts that have been requested and not been answered.
    under_way: HashSet<Part>,
    requests_under_way: usize,
    retries: Retries,
    /// Set once further requests are useless.
    is_over: bool,
    faults: Vec<StreamFault>,
    counts: StreamCounts,
    now: Duration,
}

#[derive(Debug)]
enum State {
    Opening(Beginning),
    Open(Box<Open>),
}

impl Resident {
    /// Creates a stream of a file that has not been read yet.
    pub fn new(options: StreamOptions) -> Self {
        Self {
            options,
            state: State::Opening(Beginning::default()),
            under_way: HashSet::new(),
            requests_under_way: 0,
            retries: Retries::default(),
            is_over: false,
            faults: Vec::new(),
            counts: StreamCounts::default(),
            now: Duration::ZERO,
        }
    }

    /// Whether the beginning of the file has been read. Every point then has an answer, once the writes that
    /// [`Resident::take_writes`] returns are done.
    pub fn is_open(&self) -> bool {
        matches!(self.state, State::Open(_))
    }

    /// Returns the options.
    pub fn options(&self) -> &StreamOptions {
        &self.options
    }

    /// Returns the number of words of the pool.
    pub fn pool_words(&self) -> u32 {
        u32::try_from(self.options.budget_bytes / 4).unwrap_or(u32::MAX).min(1 << 31)
    }

    fn open(&self) -> Option<&Open> {
        match &self.state {
            State::Open(open) => Some(open),
            State::Opening(_) => None,
        }
    }

    /// Returns the settings of the bake, once the file is open.
    pub fn settings(&self) -> Option<&FileSettings> {
        self.open().map(|open| &open.contents.header.settings)
    }

    /// Returns the grids of the levels in use, each with its level in the file, the finest first. The list is
    /// empty until the file is open.
    pub fn grids(&self) -> Vec<(u32, LightGrid)> {
        let levels = self.open().map(|open| &open.layout.levels[..]).unwrap_or_default();
        levels.iter().map(|places| (places.level, places.grid)).collect()
    }

    /// Returns the first word of the pool that pages may have, once the file is open.
    pub fn first_page_word(&self) -> Option<u32> {
        self.open().map(|open| open.layout.pages_at)
    }

    /// Takes the current views, chooses the bundles that should be resident, and lets levels fade by a frame.
    /// `now` is the time since any fixed moment.
    ///
    /// Cost: some microseconds per bundle near a view.
    pub fn update(&mut self, views: &[View], now: Duration) {
        self.now = now;
        let options = self.options;
        if let State::Open(open) = &mut self.state {
            if open.views != views || !open.residents.has_choice() {
                open.choose(views, &options);
            }
            open.residents.fade();
        }
    }

    /// Returns the next request, if any is due. Call it until it returns `None`.
    pub fn next_request(&mut self) -> Option<Request> {
        if self.is_over || self.requests_under_way >= MAX_REQUESTS {
            return None;
        }
        let (under_way, retries, now) = (&self.under_way, &self.retries, self.now);
        let may_ask = |part: Part| !under_way.contains(&part) && retries.allow(part, now);
        let request = match &self.state {
            State::Opening(beginning) => may_ask(Part::Beginning)
                .then(|| Request { range: beginning.range(), job: Job::Beginning(beginning.clone()) }),
            State::Open(open) => open.next_request(may_ask),
        }?;
        self.under_way.extend(request.parts());
        self.requests_under_way += 1;
        Some(request)
    }

    /// Takes the answer to a request.
    pub fn deliver(&mut self, Answer { bytes, loaded }: Answer) {
        self.requests_under_way -= 1;
        self.counts.requests += 1;
        self.counts.bytes += bytes;
        match loaded {
            Loaded::Beginning(result) => {
                let opened = result.and_then(|opened| match opened {
                    Opened::More(beginning) => Ok(State::Opening(beginning)),
                    Opened::Whole(file) => {
                        let open = Open::new(*file, &self.options, self.pool_words())?;
                        Ok(State::Open(Box::new(open)))
                    }
                });
                let state = self.settled(Part::Beginning, opened);
                // After a fault, the bytes read so far may be those of another file.
                self.state = state.unwrap_or_else(|| State::Opening(Beginning::default()));
            }
            Loaded::Common { level, result } => {
                if let Some(context) = self.settled(Part::Common { level }, result)
                    && let State::Open(open) = &mut self.state
                {
                    open.add_common(context);
                }
            }
            Loaded::Bundles { level, bundles } => {
                for (index, result) in bundles {
                    let id = BundleId { level, index };
                    if let Some(bundle) = self.settled(Part::Bundle(id), result)
                        && let State::Open(open) = &mut self.state
                    {
                        open.residents.add(id, bundle);
                    }
                }
            }
        }
    }

    /// Records how the request for a part ended. Returns what was loaded, or `None` after a fault.
    fn settled<T>(&mut self, part: Part, result: Result<T, StreamError>) -> Option<T> {
        self.under_way.remove(&part);
        let error = match result {
            Ok(loaded) => {
                self.retries.succeed(part);
                return Some(loaded);
            }
            Err(error) => error,
        };
        let is_final = error.is_final();
        let retry_in = (!is_final).then(|| self.retries.fail(part, self.now));
        // Parts of a changed file that were requested together fail together. Report one fault.
        if !(self.is_over && is_final) {
            self.faults.push(StreamFault { part: part.to_string(), error, retry_in });
        }
        self.is_over |= is_final;
        None
    }

    /// Lets everything that failed be requested again immediately.
    pub fn retry(&mut self) {
        self.retries.forget();
        self.is_over = false;
    }

    /// Whether a requested part is missing because of a fault.
    pub fn has_failed(&self) -> bool {
        self.is_over || !self.retries.is_empty()
    }

    /// Takes the faults since the last call. Where a part is missing, a coarser level still answers.
    pub fn take_faults(&mut self) -> Vec<StreamFault> {
        std::mem::take(&mut self.faults)
    }

    /// Takes the next writes to the pool, of at most `max_bytes` bytes. Perform them in this order, and
    /// before the next frame is drawn.
    pub fn take_writes(&mut self, max_bytes: usize) -> Vec<PoolWrite> {
        match &mut self.state {
            State::Opening(_) => Vec::new(),
            State::Open(open) => open.residents.pool.take(max_bytes / 4),
        }
    }

    /// Returns the work that has been done, and the work that is left.
    pub fn counts(&self) -> StreamCounts {
        let Some(open) = self.open() else { return self.counts };
        let missing = open.chosen.iter().filter(|id| !open.residents.is_resident(**id));
        StreamCounts {
            file_bytes: open.contents.header.file_bytes,
            decoded_bytes: open.decoded_bytes,
            resident_bytes: 4 * u64::from(open.layout.words - open.residents.pool.free_words()),
            resident_bundles: open.residents.len() as u32,
            chosen_bundles: open.chosen.len() as u32,
            missing_bundles: missing.count() as u32,
            queued_bytes: 4 * open.residents.pool.queued_words() as u64,
            ..self.counts
        }
    }

    /// Whether all bundles that views need and that fit the budget are resident, taken for writing, and not
    /// fading.
    pub fn is_settled(&self) -> bool {
        self.open().is_some_and(|open| open.residents.are_settled())
    }

    /// Returns the WGSL of look-ups: a uniform buffer of eight [parameter blocks](Parameters), the first of
    /// which are those of the [levels](Self::parameters), at the first binding, and a read-only storage
    /// buffer with the words at the next. It defines the functions of
    /// [`FileForGpu::wgsl`](crate::gpu::FileForGpu::wgsl).
    pub fn wgsl(&self, bindings: Bindings) -> String {
        of_stream(bindings)
    }

    /// Returns the parameters of look-ups in each level in use, the finest first. Penumbrae have the same
    /// radius in the world in each level.
    ///
    /// # Errors
    /// Returns the errors of [`Parameters::new`].
    pub fn parameters(&self, look_up: &LookUp, anchor_world: [f64; 3]) -> Result<Vec<Parameters>> {
        let Some(open) = self.open() else { return Ok(Vec::new()) };
        let bias = open.contents.header.settings.bias;
        let levels = &open.layout.levels;
        let finest = levels.first().map_or(1.0, |places| places.grid.voxel_size);
        let of_level = |(i, places): (usize, &LevelPlaces)| {
            let mut look_up = *look_up;
            if let Some(penumbra) = &mut look_up.penumbra {
                let texels = penumbra.max_radius_texels * finest / places.grid.voxel_size;
                penumbra.max_radius_texels = texels.max(1.0);
            }
            let mut parameters =
                Parameters::of_grid(&places.grid, bias, places.words, &look_up, anchor_world)?;
            parameters.coarser_levels = (levels.len() - 1 - i) as u32;
            parameters.may_lack_pages = parameters.coarser_levels > 0;
            parameters.pages_fade = places.fades;
            Ok(parameters)
        };
        levels.iter().enumerate().map(of_level).collect()
    }

    /// Returns the first bytes of a look-up texture whose texels from the 128th on are the words of the pool:
    /// 128 words for each level in use, the finest first. So [`StreamOptions::reserved_words`] are 128 for
    /// each coarser level; 896 are enough for any file. Empty until the file is open.
    ///
    /// # Errors
    /// Returns the errors of [`Parameters::new`].
    pub fn texture_headers(&self, look_up: &LookUp) -> Result<Vec<u8>> {
        let place = |(_, grid): (u32, LightGrid)| grid.placed(&look_up.placement);
        let grids: Vec<_> = self.grids().into_iter().map(place).collect();
        let Some(finest) = grids.first() else { return Ok(Vec::new()) };
        let anchor_world = middle(finest);
        let levels = self.parameters(look_up, anchor_world.map(f64::from))?;
        let mut bytes = Vec::new();
        for (parameters, grid) in levels.iter().zip(&grids) {
            put_header(&mut bytes, parameters, anchor_world, grid, self.pool_words());
        }
        Ok(bytes)
    }

    /// Returns look-ups in the words of the pool, once the file is open.
    pub fn sampler(&self, filter: Filter) -> Option<PoolSampler> {
        let open = self.open()?;
        let bias = open.contents.header.settings.bias;
        Some(PoolSampler::new(Arc::clone(&open.layout), bias, filter))
    }
}
