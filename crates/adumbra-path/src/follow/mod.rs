//! Follows a sun at run time: keys are baked ahead of it in the background, coarse to fine.
//!
//! An engine passes its sun in every frame, and gets two key files between which a march answers. The
//! follower derives the sun's speed and direction of motion. The reader plays a baked path with the same
//! interface. Data flows one way: motion → keys → worker and moment → follower and reader.

mod keys;
mod moment;
mod motion;
mod reader;
mod worker;

use std::sync::Arc;

use adumbra::ShadowFile;
use adumbra_bake::BakeOptions;
use adumbra_scene::Scene;

use self::keys::{Keys, STAGES};
use self::moment::Shown;
pub use self::moment::{Followed, FollowedMoment};
use self::motion::Motion;
pub use self::reader::PathReader;
use self::worker::Worker;
use crate::error::{Error, Result};

/// Settings of a follower.
#[derive(Clone, Debug)]
pub struct FollowOptions {
    /// Settings of each key's bake. Its sun, frame and levels are the follower's.
    pub bake: BakeOptions,
    /// Number of threads that only bake; 1 unless set.
    pub threads: usize,
    /// The least elevation of a key in degrees; 3 unless set. A lower sun is answered from the key nearest to
    /// it.
    pub lowest_degrees: f64,
    /// If set, a key covers only what is within this many world units of the focus, along x and z, in place
    /// of the bounds of `bake`. Everything farther away is lit. Without it, a large world is not baked in
    /// time. The focus may move half as far before other keys are baked.
    pub near_world: Option<f64>,
}

impl FollowOptions {
    /// Returns the defaults, with these settings of each key's bake.
    pub fn new(bake: BakeOptions) -> Self {
        Self { bake, threads: 1, lowest_degrees: 3.0, near_world: None }
    }
}

/// Bakes the keys of a moving sun while the sun moves.
///
/// Cost: a call of [`SunFollower::follow`] takes microseconds and no lock. Bakes take the threads of the
/// options. At most four keys are kept.
///
/// ```no_run
/// use std::sync::Arc;
/// use adumbra::{Filter, Sun};
/// use adumbra_bake::{BakeOptions, Size};
/// use adumbra_path::{FollowOptions, Followed, SunFollower};
/// # fn scene() -> adumbra_scene::Scene { unimplemented!() }
/// # fn towards_sun(seconds: f64) -> [f64; 3] { unimplemented!() }
///
/// let sun = Sun::from_direction(towards_sun(0.0))?;
/// let options = FollowOptions::new(BakeOptions::new(sun, Size::Resolution(8192)));
/// let mut follower = SunFollower::start(Arc::new(scene()), options, || {})?;
/// // In every frame:
/// let seconds = 1.25;
/// if let Followed::Moment(moment) = follower.follow(seconds, towards_sun(seconds)) {
///     let lit = moment.sampler(Filter::Box5).visibility([12.0, 0.0, 3.0], Some([0.0, 1.0, 0.0]));
/// }
/// # use adumbra::PointVisibility;
/// # Ok::<(), adumbra_path::Error>(())
/// ```
pub struct SunFollower {
    worker: Worker,
    keys: Keys<Arc<ShadowFile>>,
    motion: Motion,
    shown: Shown,
    fault: Option<Error>,
    is_stopped: bool,
}

impl SunFollower {
    /// Starts to follow. `on_key` is called on the follower's thread when a bake has ended, for example to
    /// wake a sleeping event loop.
    ///
    /// # Errors
    /// Returns an error if the operating system gives no threads.
    pub fn start(
        scene: Arc<Scene>,
        options: FollowOptions,
        on_key: impl Fn() + Send + 'static,
    ) -> Result<Self> {
        let span_world = options.near_world.map_or(f64::INFINITY, |near| 0.5 * near);
        let keys = Keys::new(options.lowest_degrees, span_world);
        let worker = Worker::start(scene, options, on_key)?;
        Ok(Self {
            worker,
            keys,
            motion: Motion::default(),
            shown: Shown::default(),
            fault: None,
            is_stopped: false,
        })
    }

    /// Sets the place where shadows are needed, such as the camera's. It matters only with
    /// [`FollowOptions::near_world`].
    pub fn set_focus(&mut self, p_world: [f64; 3]) {
        self.keys.set_focus(p_world);
    }

    /// Takes the sun's direction, as a unit vector, at a time in seconds of any clock that never runs
    /// backwards. Returns the keys that answer for this sun. Starts the next bake if none is running.
    pub fn follow(&mut self, seconds: f64, towards_sun: [f64; 3]) -> Followed {
        self.motion.see(seconds, towards_sun);
        match self.worker.outcome() {
            Some(Ok((key, seconds))) => self.keys.insert(key, seconds),
            Some(Err(error)) => self.fault = Some(error),
            None => {}
        }
        self.keys.tidy(towards_sun, &self.motion);
        match self.worker.running() {
            Some(job) if !self.keys.wants(job, towards_sun, &self.motion) => self.worker.cancel(),
            Some(_) => {}
            None if self.fault.is_some() || self.is_stopped => {}
            None => {
                if let Some(job) = self.keys.next_job(towards_sun, &self.motion) {
                    self.worker.start_job(job);
                }
            }
        }
        self.answer(towards_sun)
    }

    /// Returns the error of a bake that failed since the last call, and allows the next bake. Until this
    /// call, a follower does not bake after an error, and keeps its keys.
    pub fn take_fault(&mut self) -> Option<Error> {
        self.fault.take()
    }

    /// Stops all further bakes, for example if every bake would fail in the same way. The existing keys still
    /// answer.
    pub fn stop(&mut self) {
        self.is_stopped = true;
    }

    /// Whether a bake is running.
    pub fn is_baking(&self) -> bool {
        self.worker.running().is_some()
    }

    fn answer(&mut self, towards_sun: [f64; 3]) -> Followed {
        if towards_sun[1] <= 0.0 {
            return Followed::Night;
        }
        let Some(around) = self.keys.around(towards_sun, &self.motion) else { return Followed::Waiting };
        let keys = around.map(|key| Arc::clone(&key.file));
        let coarser = around.map(|key| STAGES[key.stage]);
        Followed::Moment(self.shown.moment(keys, towards_sun, coarser[0].max(coarser[1])))
    }
}
