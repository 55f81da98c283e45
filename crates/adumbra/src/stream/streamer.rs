//! A stream that has its own threads.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use crate::gpu::{Bindings, LookUp, Parameters};
use crate::query::Filter;
use crate::stream::{
    Answer, PoolSampler, PoolWrite, Request, Resident, ShadowSource, StreamCounts, StreamFault,
    StreamOptions, View,
};

/// Threads that read and decode.
const THREADS: usize = 4;

/// A file that is streamed by threads in the background, with the words of its pool in memory.
pub struct Streamer {
    resident: Resident,
    requests: Sender<Request>,
    answers: Receiver<Answer>,
    words: Vec<u32>,
    begun: Instant,
}

impl Streamer {
    /// Begins to read a file, without waiting. There are no answers until [`Streamer::is_open`].
    pub fn new(source: impl ShadowSource + 'static, options: StreamOptions) -> Self {
        let source: Arc<dyn ShadowSource> = Arc::new(source);
        let (requests, taken) = channel::<Request>();
        let (given, answers) = channel();
        let taken = Arc::new(Mutex::new(taken));
        for _ in 0..THREADS {
            let (source, taken, given) = (Arc::clone(&source), Arc::clone(&taken), given.clone());
            // The threads end when the streamer is dropped, which closes the channels.
            thread::spawn(move || {
                loop {
                    let request = taken.lock().unwrap_or_else(|e| e.into_inner()).recv();
                    let Ok(request) = request else { break };
                    if given.send(request.run(&*source)).is_err() {
                        break;
                    }
                }
            });
        }
        let resident = Resident::new(options);
        let words = Vec::new();
        let mut streamer = Self { resident, requests, answers, words, begun: Instant::now() };
        streamer.ask();
        streamer
    }

    /// Takes the current views, and the threads' answers since the last call. Call it once per frame; it does
    /// not block.
    pub fn update(&mut self, views: &[View]) {
        while let Ok(answer) = self.answers.try_recv() {
            self.resident.deliver(answer);
        }
        self.resident.update(views, self.begun.elapsed());
        self.ask();
    }

    fn ask(&mut self) {
        while let Some(request) = self.resident.next_request() {
            // The threads live as long as the streamer.
            if self.requests.send(request).is_err() {
                break;
            }
        }
    }

    /// Waits until all bundles that the views need and that fit the budget are resident and written to
    /// [`Streamer::words`], or until `limit` has passed. Returns whether they are. Passes each write to
    /// `written` too.
    pub fn settle(&mut self, views: &[View], limit: Duration, mut written: impl FnMut(&PoolWrite)) -> bool {
        let end = Instant::now() + limit;
        loop {
            self.update(views);
            self.take_writes(usize::MAX).iter().for_each(&mut written);
            if self.resident.is_settled() {
                return true;
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            if let Ok(answer) = self.answers.recv_timeout(left.min(Duration::from_millis(20))) {
                self.resident.deliver(answer);
            }
        }
    }

    /// Whether every point has an answer: the beginning of the file has been read.
    pub fn is_open(&self) -> bool {
        self.resident.is_open()
    }

    /// Returns the [`Resident`], for everything that this type does not wrap.
    pub fn resident(&self) -> &Resident {
        &self.resident
    }

    /// Takes the next writes to the pool on the GPU, of at most `max_bytes` bytes, in this order, and applies
    /// them to [`Streamer::words`].
    pub fn take_writes(&mut self, max_bytes: usize) -> Vec<PoolWrite> {
        let writes = self.resident.take_writes(max_bytes);
        if !writes.is_empty() && self.words.is_empty() {
            self.words = vec![0; self.resident.pool_words() as usize];
        }
        for PoolWrite { at, words } in &writes {
            self.words[*at as usize..][..words.len()].copy_from_slice(words);
        }
        writes
    }

    /// Returns the words of the pool. They are empty until the first [`Streamer::take_writes`] after the file
    /// is open.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Returns look-ups in [`Streamer::words`], once they hold the coarsest level.
    pub fn sampler(&self, filter: Filter) -> Option<PoolSampler> {
        self.resident.sampler(filter).filter(|_| !self.words.is_empty())
    }

    /// Returns the WGSL of look-ups, see [`Resident::wgsl`].
    pub fn wgsl(&self, bindings: Bindings) -> String {
        self.resident.wgsl(bindings)
    }

    /// Returns the parameters of look-ups in each level in use, see [`Resident::parameters`].
    ///
    /// # Errors
    /// Returns the errors of [`Resident::parameters`].
    pub fn parameters(&self, look_up: &LookUp, anchor_world: [f64; 3]) -> crate::Result<Vec<Parameters>> {
        self.resident.parameters(look_up, anchor_world)
    }

    /// Takes the faults since the last call.
    pub fn take_faults(&mut self) -> Vec<StreamFault> {
        self.resident.take_faults()
    }

    /// Lets everything that failed be requested again immediately.
    pub fn retry(&mut self) {
        self.resident.retry();
        self.ask();
    }

    /// Returns the work that has been done, and the work that is left.
    pub fn counts(&self) -> StreamCounts {
        self.resident.counts()
    }
}

impl std::fmt::Debug for Streamer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Streamer").field("counts", &self.counts()).finish_non_exhaustive()
    }
}
