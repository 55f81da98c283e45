//! A bake on separate threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;

use adumbra::Sun;
use adumbra_bake::{Bake, BakeCache, BakeOptions, MemoryCache, Size};
use adumbra_scene::Scene;
use bevy::math::Vec3;

use super::BakeSettings;
use super::progress::BakeError;
use crate::threads::pool;
use crate::{BakedShadowFile, DeviceLimits};

/// A bake that is under way. Dropping it cancels the bake.
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

/// A finished file.
pub(super) struct Finished {
    pub(super) file: BakedShadowFile,
    pub(super) seconds: f64,
    pub(super) triangles: u64,
    /// Number of root blocks, and how many of them are reused from an earlier bake.
    pub(super) blocks: [usize; 2],
    /// Whether it has the requested resolution.
    pub(super) is_last: bool,
}

impl Job {
    /// Starts a bake. `cache` holds the results of earlier bakes of the light.
    pub(super) fn start(
        scene: Scene,
        settings: BakeSettings,
        towards_light: Vec3,
        limits: DeviceLimits,
        cache: Arc<MemoryCache>,
    ) -> Self {
        let (sender, receiver) = channel();
        let state = Arc::new(State::default());
        let of_thread = Arc::clone(&state);
        let work = move || {
            // Remove entries that the last bake did not use: they are unlikely to be needed again.
            cache.remove_unused();
            let inputs = Inputs { scene, settings, towards_light, limits, cache };
            if let Err(error) = work(&inputs, &of_thread, &sender) {
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

    /// Returns a bake that never ends and whose files come from a test.
    #[cfg(test)]
    pub(super) fn of_test(results: Receiver<Result<Finished, BakeError>>) -> Self {
        Self { results: Mutex::new(results), state: Arc::default() }
    }

    /// Returns the results since the last call.
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

/// The inputs of a bake.
struct Inputs {
    scene: Scene,
    settings: BakeSettings,
    towards_light: Vec3,
    limits: DeviceLimits,
    cache: Arc<dyn BakeCache>,
}

fn work(
    inputs: &Inputs,
    state: &State,
    results: &Sender<Result<Finished, BakeError>>,
) -> Result<(), BakeError> {
    let Inputs { scene, settings, towards_light, limits, cache } = inputs;
    let sun = Sun::from_direction(towards_light.to_array().map(f64::from));
    let sun = sun.map_err(|e| BakeError::Sun(e.into()))?;
    let pool = pool(settings.threads).map_err(|e| BakeError::Threads(e.into()))?;
    let coarse = settings.first_resolution.min(settings.resolution);
    let resolutions =
        if coarse == settings.resolution { vec![coarse] } else { vec![coarse, settings.resolution] };
    let triangles = scene.instanced_triangles();
    for resolution in resolutions {
        let options = BakeOptions::new(sun, Size::Resolution(resolution.into()))
            .with(|o| o.thickness_world = settings.thickness_world.into());
        let report = |progress: adumbra_bake::Progress| {
            if let Ok(mut state) = state.progress.lock() {
                *state = (resolution, progress.done as f32 / progress.total.max(1) as f32);
            }
        };
        let bake = Bake::with_options(scene, &options)
            .cache(Arc::clone(cache))
            .on_progress(report)
            .cancel(&state.cancel);
        let baked = pool.install(|| bake.in_memory_with_report());
        if state.cancel.load(Ordering::Relaxed) {
            return Ok(());
        }
        let (file, report) = baked.map_err(|e| BakeError::Bake(e.into()))?;
        let file = BakedShadowFile::new(file, *limits);
        let file = file.map_err(|e| BakeError::File(e.into()))?;
        let is_last = resolution == settings.resolution;
        let blocks = [report.root_blocks, report.reused_root_blocks];
        let finished = Finished { file, seconds: report.seconds, triangles, blocks, is_last };
        if results.send(Ok(finished)).is_err() {
            return Ok(());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use adumbra::{Encoding, ShadowFile};
    use adumbra_bake::Bake;
    use adumbra_scene::{GeneratedKind, generate};

    use super::*;

    fn finished(job: &Job) -> Vec<Finished> {
        let mut all = Vec::new();
        while job.progress().is_some() {
            thread::sleep(Duration::from_millis(10));
        }
        for finished in job.finished() {
            all.push(finished.unwrap_or_else(|error| panic!("{error}")));
        }
        all
    }

    fn bytes(file: &ShadowFile) -> Vec<u8> {
        file.to_bytes(Encoding::Raw).expect("a file that was baked")
    }

    #[test]
    fn rebakes_only_blocks_that_a_moved_mesh_touches() {
        let mut scene = generate(GeneratedKind::City, 1);
        let settings = BakeSettings { resolution: 2048, first_resolution: 512, ..BakeSettings::default() };
        let light = Vec3::new(0.5, 0.8, 0.35);
        let cache = Arc::new(MemoryCache::default());
        let limits = DeviceLimits::default();
        let start = |scene: &Scene| Job::start(scene.clone(), settings, light, limits, cache.clone());
        let first = finished(&start(&scene));
        assert_eq!(first.iter().map(|file| file.is_last).collect::<Vec<_>>(), [false, true]);
        assert!(first.iter().all(|file| file.blocks[1] == 0));
        scene.instances[700].world_from_mesh[0][3] += 0.5;
        let again = finished(&start(&scene));
        let [blocks, reused] = again[1].blocks;
        assert!(reused > blocks / 2 && reused < blocks, "{reused} of {blocks}");
        let sun = Sun::from_direction(light.to_array().map(f64::from)).unwrap();
        let fresh = Bake::new(&scene, sun).resolution(2048).in_memory().unwrap();
        assert!(bytes(again[1].file.file()) == bytes(&fresh));
    }
}
