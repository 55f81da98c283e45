//! A bake on threads of its own.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;

use adumbra::Sun;
use adumbra_bake::{BakeOptions, Size, Watch, bake};
use adumbra_scene::Scene;
use bevy::math::Vec3;

use super::BakeSettings;
use super::progress::BakeError;
use crate::threads::pool;
use crate::{BakedShadowFile, DeviceLimits};

/// A bake that is under way. It ends soon after this is dropped.
#[derive(Debug)]
pub(super) struct Job {
    results: Mutex<Receiver<Result<Finished, BakeError>>>,
    state: Arc<State>,
}

#[derive(Debug, Default)]
struct State {
    cancel: AtomicBool,
    done: AtomicBool,
    /// Resolution of the file that is being made, and the share of its blocks that are done.
    progress: Mutex<(u32, f32)>,
}

/// A file that is done.
pub(super) struct Finished {
    pub(super) file: BakedShadowFile,
    pub(super) seconds: f64,
    pub(super) triangles: u64,
    /// Whether it has the resolution that was asked for.
    pub(super) is_last: bool,
}

impl Job {
    pub(super) fn start(
        scene: Scene,
        settings: BakeSettings,
        towards_light: Vec3,
        limits: DeviceLimits,
    ) -> Self {
        let (sender, receiver) = channel();
        let state = Arc::new(State::default());
        let of_thread = Arc::clone(&state);
        let work = move || {
            if let Err(error) = work(&scene, settings, towards_light, limits, &of_thread, &sender) {
                // The app may have dropped the bake.
                let _ = sender.send(Err(error));
            }
            of_thread.done.store(true, Ordering::Release);
        };
        if let Err(error) = thread::Builder::new().name("bake shadows".to_owned()).spawn(work) {
            state.done.store(true, Ordering::Release);
            let (sender, results) = channel();
            let _ = sender.send(Err(BakeError::Threads(error.into())));
            return Self { results: Mutex::new(results), state };
        }
        Self { results: Mutex::new(receiver), state }
    }

    /// Returns what was finished since the last call.
    pub(super) fn finished(&self) -> Vec<Result<Finished, BakeError>> {
        self.results.lock().map(|results| results.try_iter().collect()).unwrap_or_default()
    }

    /// Returns the resolution that is being baked and the share that is done; `None` at the end.
    pub(super) fn progress(&self) -> Option<(u32, f32)> {
        let is_done = self.state.done.load(Ordering::Acquire);
        (!is_done).then(|| self.state.progress.lock().map(|progress| *progress).unwrap_or_default())
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        self.state.cancel.store(true, Ordering::Relaxed);
    }
}

fn work(
    scene: &Scene,
    settings: BakeSettings,
    towards_light: Vec3,
    limits: DeviceLimits,
    state: &State,
    results: &Sender<Result<Finished, BakeError>>,
) -> Result<(), BakeError> {
    let sun = Sun::from_direction(towards_light.to_array().map(f64::from));
    let sun = sun.map_err(|e| BakeError::Sun(e.into()))?;
    let pool = pool(settings.threads).map_err(|e| BakeError::Threads(e.into()))?;
    let coarse = settings.first_resolution.min(settings.resolution);
    let resolutions =
        if coarse == settings.resolution { vec![coarse] } else { vec![coarse, settings.resolution] };
    let triangles = scene.instanced_triangles();
    for resolution in resolutions {
        let options = BakeOptions {
            thickness_world: settings.thickness_world.into(),
            ..BakeOptions::new(sun, Size::Resolution(resolution.into()))
        };
        let report = |progress: adumbra_bake::Progress| {
            if let Ok(mut state) = state.progress.lock() {
                *state = (resolution, progress.done_tiles as f32 / progress.total_tiles.max(1) as f32);
            }
        };
        let baked = pool.install(|| bake(scene, &options, Watch::new(&report, &state.cancel)));
        if state.cancel.load(Ordering::Relaxed) {
            return Ok(());
        }
        let baked = baked.map_err(|e| BakeError::Bake(e.into()))?;
        let file = BakedShadowFile::new(baked.file, limits);
        let file = file.map_err(|e| BakeError::File(e.into()))?;
        let is_last = resolution == settings.resolution;
        let finished = Finished { file, seconds: baked.report.seconds, triangles, is_last };
        if results.send(Ok(finished)).is_err() {
            return Ok(());
        }
    }
    Ok(())
}
