//! A streamed file: its pool of words on the device, updated with the data that its [`Streamer`] has read.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock};
use std::time::Duration;

use adumbra::gpu::{LookUp, Parameters};
use adumbra::stream::{PoolWrite, StreamCounts, StreamFault, Streamer, View};
use adumbra::{FileSettings, LightGrid, Placement, Sun};
use adumbra_scene::{Camera, Projection};

use super::WordBuffers;
use crate::error::{RenderError, Result};
use crate::gpu::Gpu;

/// A streamed file. Techniques of one device share it. Each frame that one of them draws advances the stream.
pub struct StreamedFile {
    streamer: Mutex<Streamer>,
    grid: LightGrid,
    settings: FileSettings,
    /// Largest number of bytes that a frame writes to the device.
    upload_bytes: usize,
    pool: OnceLock<Arc<WordBuffers>>,
    /// Whether the last frame had everything that its camera needs.
    is_settled: AtomicBool,
}

impl StreamedFile {
    /// Waits up to `limit` for the beginning of a file to be read. A frame writes up to `upload_bytes` to the
    /// device.
    ///
    /// # Errors
    /// Returns [`RenderError::Stream`] if the file cannot be opened, or is not opened within `limit`.
    pub fn open(mut streamer: Streamer, upload_bytes: usize, limit: Duration) -> Result<Self> {
        streamer.settle(&[], limit, |_| ());
        let resident = streamer.resident();
        let (Some(&(_, grid)), Some(&settings)) = (resident.grids().first(), resident.settings()) else {
            let fault = streamer.take_faults().into_iter().next();
            let slow = || format!("its beginning was not read within {} s", limit.as_secs_f64());
            return Err(RenderError::Stream { what: fault.map_or_else(slow, |fault| fault.to_string()) });
        };
        Ok(Self {
            streamer: Mutex::new(streamer),
            grid,
            settings,
            upload_bytes,
            pool: OnceLock::new(),
            is_settled: AtomicBool::new(false),
        })
    }

    /// The grid of the finest level in use.
    pub fn grid(&self) -> &LightGrid {
        &self.grid
    }

    /// The settings of the bake.
    pub fn settings(&self) -> &FileSettings {
        &self.settings
    }

    /// The sun that the file was baked for.
    pub fn sun(&self) -> Sun {
        self.grid.sun
    }

    /// Counts of the completed and the remaining work.
    pub fn counts(&self) -> StreamCounts {
        self.streamer().counts()
    }

    /// Takes the faults that occurred since the last call.
    pub fn take_faults(&self) -> Vec<StreamFault> {
        self.streamer().take_faults()
    }

    /// Retries everything that failed, at once.
    pub fn retry(&self) {
        self.streamer().retry();
    }

    /// Whether the last frame had everything that its camera needs and that fits the budget.
    pub fn is_settled(&self) -> bool {
        self.is_settled.load(Ordering::Relaxed)
    }

    /// Locks and returns the streamer. Frames wait while it is locked.
    pub fn streamer(&self) -> MutexGuard<'_, Streamer> {
        self.streamer.lock().unwrap_or_else(|e| e.into_inner())
    }

    /// Returns the pool on the device. The first call creates it.
    pub(super) fn pool(&self, gpu: &Gpu) -> Result<Arc<WordBuffers>> {
        if let Some(pool) = self.pool.get() {
            return Ok(Arc::clone(pool));
        }
        let streamer = self.streamer();
        let words = streamer.resident().pool_words();
        let pool = Arc::new(WordBuffers::empty(gpu, "voxel::pool", words.into())?);
        pool.write(gpu, 0, streamer.words());
        Ok(Arc::clone(self.pool.get_or_init(|| pool)))
    }

    /// Updates the stream with the current view of an app's camera, and writes new data to the device.
    /// `placement` is the placement of the file in the app's world. Does not wait.
    pub(super) fn advance(&self, gpu: &Gpu, camera: &Camera, placement: &Placement) {
        let mut streamer = self.streamer();
        streamer.update(&[view_of(camera).of_placed(placement)]);
        let writes = streamer.take_writes(self.upload_bytes);
        self.write(gpu, &writes);
        self.is_settled.store(streamer.resident().is_settled(), Ordering::Relaxed);
    }

    /// Waits up to `limit` until the device has everything that a camera in the file's world needs and that
    /// fits the budget. Returns whether it has.
    pub fn settle(&self, gpu: &Gpu, camera: &Camera, limit: Duration) -> bool {
        let mut streamer = self.streamer();
        let is_settled =
            streamer.settle(&[view_of(camera)], limit, |write| self.write(gpu, std::slice::from_ref(write)));
        self.is_settled.store(is_settled, Ordering::Relaxed);
        is_settled
    }

    fn write(&self, gpu: &Gpu, writes: &[PoolWrite]) {
        // A pool that is created later starts with all words written so far.
        if let Some(pool) = self.pool.get() {
            for write in writes {
                pool.write(gpu, write.at.into(), &write.words);
            }
        }
    }

    pub(super) fn parameters(&self, look_up: &LookUp, anchor_world: [f64; 3]) -> Result<Vec<Parameters>> {
        Ok(self.streamer().parameters(look_up, anchor_world)?)
    }

    pub(super) fn grids(&self) -> Vec<LightGrid> {
        self.streamer().resident().grids().into_iter().map(|(_, grid)| grid).collect()
    }
}

/// Returns a camera as the view that pages are selected by.
pub fn view_of(camera: &Camera) -> View {
    let view = camera.view();
    let size = [camera.width, camera.height];
    match camera.projection {
        Projection::Perspective { fov_degrees } => {
            View::perspective(view.eye, view.forward, view.up, fov_degrees, size)
        }
        Projection::Orthographic { height_world } => {
            View::parallel(view.eye, view.forward, view.up, height_world, size)
        }
    }
}
