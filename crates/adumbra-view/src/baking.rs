//! A background bake, coarse to fine: each level is shown as soon as it is done, and cancelling keeps the
//! last one.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::thread;

use adumbra::Sun;
use adumbra_bake::{Bake, BakeCache, BakeOptions, MemoryCache, Progress, Size};

use crate::background::{background_pool, caught};
use crate::event::{Event, EventSender};
use crate::loaded_scene::LoadedScene;
use crate::settings::Settings;

/// Resolution of the coarsest level, in texels on the longest side.
const COARSEST: u64 = 512;
/// Ratio of the resolutions of consecutive levels.
const STEP: u64 = 4;

/// The inputs of a bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BakeKey {
    /// Number of the scene.
    pub(crate) scene: u64,
    pub(crate) sun: Sun,
    /// Resolution of the finest level, in texels on the longest side.
    pub(crate) resolution: u64,
}

/// A bake in progress.
pub(crate) struct RunningBake {
    /// Unique number, which distinguishes two bakes with the same key.
    pub(crate) number: u64,
    pub(crate) key: BakeKey,
    /// Resolution of the level being baked.
    pub(crate) resolution: u64,
    pub(crate) share: f32,
    cancel: Arc<AtomicBool>,
}

impl BakeKey {
    /// Returns the key of the bake that these settings require.
    pub(crate) fn new(scene: u64, settings: &Settings) -> Self {
        Self { scene, sun: settings.sun, resolution: settings.resolution }
    }
}

/// Returns the resolutions of the levels, coarse to fine.
fn levels(finest: u64) -> Vec<u64> {
    let mut levels: Vec<u64> =
        std::iter::successors(Some(finest), |r| Some(r / STEP)).take_while(|&r| r >= COARSEST).collect();
    if levels.is_empty() {
        levels.push(finest);
    }
    levels.reverse();
    levels
}

impl RunningBake {
    /// Starts a bake. `cache` has the results of earlier bakes, which are reused if there is no memory limit.
    pub(crate) fn start(
        key: BakeKey,
        scene: Arc<LoadedScene>,
        max_memory: Option<u64>,
        cache: Arc<MemoryCache>,
        sender: EventSender,
    ) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let cancel = Arc::new(AtomicBool::new(false));
        let seen = cancel.clone();
        thread::spawn(move || {
            let outcome = caught(|| {
                let pool = background_pool()?;
                // Remove entries that the last bake did not use: they are unlikely to be needed again.
                cache.remove_unused();
                let cache = max_memory.is_none().then_some(cache as Arc<dyn BakeCache>);
                let inputs = Inputs { scene: &scene, max_memory, cache };
                pool.install(|| bake_levels(number, key, &inputs, &seen, &sender)).map_err(|e| e.to_string())
            });
            if let Err(error) = outcome {
                let error = (!seen.load(Ordering::Relaxed)).then_some(error);
                sender.send(Event::BakeEnded { bake: number, error });
            }
        });
        Self { number, key, resolution: levels(key.resolution)[0], share: 0.0, cancel }
    }

    /// Requests the bake to stop.
    pub(crate) fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Drop for RunningBake {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// The scene, memory limit and cache of a bake.
struct Inputs<'a> {
    scene: &'a LoadedScene,
    max_memory: Option<u64>,
    cache: Option<Arc<dyn BakeCache>>,
}

fn bake_levels(
    number: u64,
    key: BakeKey,
    inputs: &Inputs<'_>,
    cancel: &AtomicBool,
    sender: &EventSender,
) -> Result<(), adumbra_bake::Error> {
    for resolution in levels(key.resolution) {
        // Reports each percent once, because the window redraws its panel for each report.
        let reported = AtomicU32::new(0);
        let done = |p: Progress| {
            let share = p.done as f64 / p.total.max(1) as f64;
            let percent = (100.0 * share) as u32;
            if reported.fetch_max(percent, Ordering::Relaxed) < percent {
                sender.send(Event::Baking { bake: number, resolution, share: share as f32 });
            }
        };
        let options = BakeOptions::new(key.sun, Size::Resolution(resolution)).with(|o| {
            o.ignore_alpha = inputs.scene.ignore_alpha;
            o.max_memory_bytes = inputs.max_memory;
        });
        let mut bake = Bake::with_options(&inputs.scene.still, &options).on_progress(done).cancel(cancel);
        if let Some(cache) = &inputs.cache {
            bake = bake.cache(Arc::clone(cache));
        }
        let file = bake.in_memory()?;
        let last = resolution == key.resolution;
        sender.send(Event::Baked { bake: number, file: Box::new(file), last });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::sync::mpsc;

    use adumbra_scene::{GeneratedKind, generate};

    use super::*;
    use crate::settings::tests::settings;

    fn scene() -> Arc<LoadedScene> {
        let scene = generate(GeneratedKind::Primitives, 1);
        Arc::new(LoadedScene::new(PathBuf::from("primitives"), scene, false))
    }

    #[test]
    fn levels_rise_to_the_requested_resolution() {
        assert_eq!(levels(8192), [512, 2048, 8192]);
        assert_eq!(levels(1024), [1024]);
        assert_eq!(levels(256), [256]);
    }

    #[test]
    fn bake_sends_every_level() {
        let sun = Sun::from_angles(40.0, 50.0).unwrap();
        let (channel, events) = mpsc::channel();
        let sender = EventSender::new(move |event| channel.send(event).unwrap());
        let key = BakeKey::new(1, &Settings { sun, resolution: 2048, ..settings() });
        let running = RunningBake::start(key, scene(), None, Arc::default(), sender);
        let mut landed = Vec::new();
        for event in events {
            match event {
                Event::Baked { bake, file, last } => {
                    assert_eq!(bake, running.number);
                    landed.push((file.settings.resolution, last));
                }
                Event::BakeEnded { error, .. } => panic!("{error:?}"),
                _ => {}
            }
        }
        assert_eq!(landed, [(512, false), (2048, true)]);
    }

    #[test]
    fn a_bake_that_panics_ends_with_a_message() {
        let mut broken = generate(GeneratedKind::Primitives, 1);
        broken.instances[0].mesh = u32::MAX;
        let path = PathBuf::from("broken");
        let (whole, still) = (Arc::new(broken.clone()), Arc::new(broken));
        let sound = LoadedScene::new(path, generate(GeneratedKind::Primitives, 1), false);
        let scene = Arc::new(LoadedScene { whole, still, ..sound });
        let (channel, events) = mpsc::channel();
        let sender = EventSender::new(move |event| channel.send(event).unwrap());
        let running = RunningBake::start(BakeKey::new(1, &settings()), scene, None, Arc::default(), sender);
        let ended: Vec<_> = events.iter().collect();
        let [Event::BakeEnded { bake, error: Some(error) }] = &ended[..] else { panic!("{}", ended.len()) };
        assert!(*bake == running.number && error.contains("please report it"), "{error}");
    }

    #[test]
    fn bake_that_is_cancelled_ends_without_an_error() {
        let sun = Sun::from_angles(40.0, 50.0).unwrap();
        let (channel, events) = mpsc::channel();
        let sender = EventSender::new(move |event| channel.send(event).unwrap());
        let key = BakeKey::new(1, &Settings { sun, resolution: 32_768, ..settings() });
        let running = RunningBake::start(key, scene(), None, Arc::default(), sender);
        running.cancel();
        let ended: Vec<_> =
            events.iter().filter(|n| matches!(n, Event::BakeEnded { error: None, .. })).collect();
        assert_eq!(ended.len(), 1);
    }
}
