//! One streamed file: its resident parts, and the tasks that read and decode.

use std::sync::Arc;
use std::time::{Duration, Instant};

use adumbra::stream::{Answer, PoolWrite, Request, Resident, StreamFault, StreamOptions, View};
use bevy::log::debug;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{AsyncComputeTaskPool, IoTaskPool, Task};

use super::bytes::Bytes;
use super::open::OpenFile;
use crate::SharedError;
use crate::texels::PoolTexels;

/// A streamed file.
pub(super) struct Stream {
    bytes: Arc<Bytes>,
    /// While the file is being opened, the task owns this, and an empty one takes its place.
    resident: Resident,
    opening: Option<Task<Resident>>,
    tasks: Vec<Task<Answer>>,
    opened: Option<Opened>,
    fault: Option<SharedError<StreamFault>>,
}

/// Properties of a file that is open.
struct Opened {
    pool: PoolTexels,
    towards_sun: [f64; 3],
    /// Bytes left to write before every point has an answer.
    left: u64,
}

impl Stream {
    pub(super) fn new(bytes: Bytes, options: StreamOptions) -> Self {
        Self {
            bytes: Arc::new(bytes),
            resident: Resident::new(options),
            opening: None,
            tasks: Vec::new(),
            opened: None,
            fault: None,
        }
    }

    /// Takes the answers of finished tasks: at least one, and more until the time `until`.
    pub(super) fn receive(&mut self, until: Instant) {
        if let Some(opening) = &mut self.opening {
            let Some(resident) = check_ready(opening) else { return };
            self.opening = None;
            self.resident = resident;
        }
        let resident = &mut self.resident;
        let mut has_time = true;
        self.tasks.retain_mut(|task| {
            let answer = has_time.then(|| check_ready(task)).flatten();
            let is_under_way = answer.is_none();
            if let Some(answer) = answer {
                resident.deliver(answer);
                has_time = Instant::now() < until;
            }
            is_under_way
        });
        for fault in resident.take_faults().into_iter().rev() {
            debug!("{fault}");
            self.fault = Some(fault.into());
        }
        if !resident.has_failed() {
            self.fault = None;
        }
    }

    /// Places the pool when the file is open. `place` makes the place for a number of words.
    pub(super) fn open(&mut self, place: impl FnOnce(u32) -> PoolTexels) {
        if self.opened.is_some() {
            return;
        }
        let Some((_, grid)) = self.resident.grids().into_iter().next() else { return };
        self.opened = Some(Opened {
            pool: place(self.resident.pool_words()),
            towards_sun: grid.sun.towards(),
            left: self.resident.counts().queued_bytes,
        });
    }

    /// Requests the data that views need.
    pub(super) fn ask(&mut self, views: &[View], now: Duration) {
        if self.opening.is_some() {
            return;
        }
        self.resident.update(views, now);
        while let Some(request) = self.resident.next_request() {
            let bytes = Arc::clone(&self.bytes);
            if self.resident.is_open() {
                self.tasks.push(IoTaskPool::get().spawn(answer(bytes, request)));
            } else {
                // Open in a task: all tables of a file are made at once, which takes a few milliseconds.
                let options = *self.resident.options();
                let resident = std::mem::replace(&mut self.resident, Resident::new(options));
                self.opening = Some(IoTaskPool::get().spawn(open(bytes, request, resident)));
                return;
            }
        }
    }

    /// Takes the next writes to the pool, at most `max_bytes` bytes.
    pub(super) fn take_writes(&mut self, max_bytes: usize) -> Vec<PoolWrite> {
        let Some(opened) = &mut self.opened else { return Vec::new() };
        let writes = self.resident.take_writes(max_bytes);
        opened.left = opened.left.saturating_sub(bytes_of(&writes));
        writes
    }

    pub(super) fn resident(&self) -> &Resident {
        &self.resident
    }

    /// Requests everything that has failed again at once.
    pub(super) fn retry(&mut self) {
        self.resident.retry();
    }

    /// Returns the place of the pool, once the file is open.
    pub(super) fn pool(&self) -> Option<PoolTexels> {
        self.opened.as_ref().map(|opened| opened.pool)
    }

    /// Whether every point has an answer.
    pub(super) fn is_ready(&self) -> bool {
        self.opened.as_ref().is_some_and(|opened| opened.left == 0)
    }

    /// Returns the file once it is open.
    pub(super) fn open_file(&self) -> Option<OpenFile<'_>> {
        let Opened { pool, towards_sun, left } = *self.opened.as_ref()?;
        let grid = self.resident.grids().into_iter().next().map(|(_, grid)| grid);
        Some(OpenFile { resident: &self.resident, pool, towards_sun, grid, is_ready: left == 0 })
    }

    /// Returns why a part is missing.
    pub(super) fn fault(&self) -> Option<&SharedError<StreamFault>> {
        self.fault.as_ref()
    }
}

/// Returns the number of bytes of writes.
pub(super) fn bytes_of(writes: &[PoolWrite]) -> u64 {
    writes.iter().map(|write| 4 * write.words.len() as u64).sum()
}

/// Reads the requested bytes, and decodes them in the compute pool, so that decoding does not hold up
/// loading.
async fn answer(bytes: Arc<Bytes>, request: Request) -> Answer {
    let read = bytes.read(request.range()).await;
    AsyncComputeTaskPool::get().spawn(async move { request.answer(read) }).await
}

/// Takes the next step of opening a file.
async fn open(bytes: Arc<Bytes>, request: Request, mut resident: Resident) -> Resident {
    let read = bytes.read(request.range()).await;
    let deliver = async move {
        resident.deliver(request.answer(read));
        resident
    };
    AsyncComputeTaskPool::get().spawn(deliver).await
}
