//! The thread that bakes a follower's keys, one at a time.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Instant;

use adumbra::{Bounds, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::Scene;

use super::FollowOptions;
use super::keys::{Job, Key, STAGES};
use crate::error::Result;

/// The result of a bake: a key and its time in seconds, or an error.
pub(super) type Outcome = Result<(Key<Arc<ShadowFile>>, f64)>;

/// A thread that bakes. It ends when the handle is dropped.
pub(super) struct Worker {
    jobs: Sender<Job>,
    outcomes: Receiver<Outcome>,
    running: Option<Job>,
    cancel: Arc<AtomicBool>,
}

/// The inputs of the bakes.
struct Bench {
    scene: Arc<Scene>,
    options: BakeOptions,
    near_world: Option<f64>,
    cancel: Arc<AtomicBool>,
}

impl Worker {
    /// Starts the thread, which bakes on its own thread pool. Calls `on_outcome` after each bake, on the
    /// worker.
    ///
    /// # Errors
    /// Returns an error if the operating system gives no threads.
    pub(super) fn start(
        scene: Arc<Scene>,
        options: FollowOptions,
        on_outcome: impl Fn() + Send + 'static,
    ) -> Result<Self> {
        let FollowOptions { bake: options, threads, near_world, .. } = options;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build();
        let pool = pool.map_err(std::io::Error::other)?;
        let (jobs, asked) = channel::<Job>();
        let (done, outcomes) = channel();
        let cancel = Arc::new(AtomicBool::new(false));
        let bench = Bench { scene, options, near_world, cancel: Arc::clone(&cancel) };
        thread::Builder::new().name("adumbra-follow".to_owned()).spawn(move || {
            for job in asked {
                let began = Instant::now();
                let outcome = pool.install(|| bench.bake(&job)).map(|file| {
                    let Job { towards, stage, focus } = job;
                    let key = Key { towards, stage, focus, file: Arc::new(file) };
                    (key, began.elapsed().as_secs_f64())
                });
                if done.send(outcome).is_err() {
                    return;
                }
                on_outcome();
            }
        })?;
        Ok(Self { jobs, outcomes, running: None, cancel })
    }

    /// The bake in progress.
    pub(super) fn running(&self) -> Option<&Job> {
        self.running.as_ref()
    }

    /// Starts a bake. No other bake may be running.
    pub(super) fn start_job(&mut self, job: Job) {
        self.cancel.store(false, Ordering::Relaxed);
        if self.jobs.send(job).is_ok() {
            self.running = Some(job);
        }
    }

    /// Cancels the bake in progress. Its outcome still arrives.
    pub(super) fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// Returns the outcome of the bake in progress, if it has ended. The outcome of a cancelled bake is
    /// dropped.
    pub(super) fn outcome(&mut self) -> Option<Outcome> {
        let outcome = self.outcomes.try_recv().ok()?;
        self.running = None;
        let was_cancelled = outcome.is_err() && self.cancel.load(Ordering::Relaxed);
        (!was_cancelled).then_some(outcome)
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.cancel();
    }
}

impl Bench {
    fn bake(&self, job: &Job) -> Result<ShadowFile> {
        let coarser = STAGES[job.stage];
        let size = match self.options.size {
            Size::Resolution(texels) => Size::Resolution((texels / coarser).max(1)),
            Size::VoxelSize(world) => Size::VoxelSize(world * coarser as f64),
        };
        let sun = Sun::from_direction(job.towards)?;
        let bounds = self.near_world.map(|near| self.around(job.focus, near)).or(self.options.bounds);
        let options = self.options.clone().with(|o| {
            o.sun = sun;
            o.size = size;
            o.bounds = bounds;
            o.frame = FrameChoice::Oblique;
            o.levels = 1;
        });
        Ok(Bake::with_options(&self.scene, &options).cancel(&self.cancel).in_memory()?)
    }

    /// Returns the box around a point, as high as the scene.
    fn around(&self, focus: [f64; 3], near_world: f64) -> Bounds {
        let Bounds { mut min, mut max } = self.scene.bounds();
        for axis in [0, 2] {
            // For a camera outside the scene, the box is at the scene's edge.
            let middle = focus[axis].clamp(min[axis], max[axis]);
            (min[axis], max[axis]) = (middle - near_world, middle + near_world);
        }
        Bounds { min, max }
    }
}
