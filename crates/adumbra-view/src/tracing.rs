//! Rays on another thread: the truth at each pixel, for the technique and the ambient occlusion called `truth`.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;

use adumbra::camera::Camera;
use adumbra::scene::Scene;
use adumbra_lab::truth::{SunShape, TruthTracer};
use adumbra_render::movers::BallPath;

use crate::loading::LoadedScene;
use crate::news::{News, Teller, background_pool};

/// What a picture of rays belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TraceKey {
    /// Number of the scene, and of the ball in it.
    pub(crate) scene: [u64; 2],
    /// All samples are pixels.
    pub(crate) camera: Camera,
    pub(crate) seconds: f64,
    /// Towards the sun, where its visibility is asked for.
    pub(crate) sun: Option<[f64; 3]>,
    /// Radius in world units and rays a pixel, where ambient visibility is asked for.
    pub(crate) ambient: Option<(f64, u32)>,
}

/// Visibilities of a picture's pixels.
pub(crate) struct Traced {
    pub(crate) key: TraceKey,
    pub(crate) sun: Option<Vec<f32>>,
    pub(crate) ambient: Option<Vec<f32>>,
}

struct Job {
    key: TraceKey,
    scene: Arc<LoadedScene>,
    ball: Option<BallPath>,
}

impl Job {
    /// Whether both see the same geometry.
    fn is_of_the_same(&self, other: &Placed) -> bool {
        (self.key.scene, self.key.seconds) == (other.scene, other.seconds)
    }

    /// The scene with everything where it is then.
    fn place(&self) -> Placed {
        let TraceKey { scene, seconds, .. } = self.key;
        let whole = if self.ball.is_none() && self.scene.whole.movers.is_empty() {
            self.scene.whole.clone()
        } else {
            let mut placed = (*self.scene.whole).clone();
            if let Some(ball) = &self.ball {
                ball.add_to(&mut placed);
            }
            placed.pose(seconds);
            Arc::new(placed)
        };
        Placed { scene, seconds, whole, ignore_alpha: self.scene.ignore_alpha }
    }
}

/// A scene at a time.
struct Placed {
    scene: [u64; 2],
    seconds: f64,
    whole: Arc<Scene>,
    ignore_alpha: bool,
}

/// The thread. It traces the newest picture asked for; older ones that it has not begun are dropped.
pub(crate) struct TraceThread {
    jobs: Sender<Job>,
    asked: Option<TraceKey>,
}

impl TraceThread {
    pub(crate) fn start(teller: Teller) -> Self {
        let (jobs, received) = mpsc::channel();
        thread::spawn(move || trace_all(&received, &teller));
        Self { jobs, asked: None }
    }

    /// Asks for a picture, unless it is the one asked for last: then false. The key's time places what moves, and the ball.
    pub(crate) fn ask(&mut self, key: TraceKey, scene: &Arc<LoadedScene>, ball: Option<&BallPath>) -> bool {
        if self.asked == Some(key) {
            return false;
        }
        self.asked = Some(key);
        // The thread lives as long as this.
        let _ = self.jobs.send(Job { key, scene: scene.clone(), ball: ball.cloned() });
        true
    }
}

fn trace_all(jobs: &Receiver<Job>, teller: &Teller) {
    let mut next = jobs.recv().ok();
    while let Some(mut job) = next.take() {
        let pool = match background_pool() {
            Ok(pool) => pool,
            Err(error) => {
                teller.tell(News::NotTraced { error });
                next = jobs.recv().ok();
                continue;
            }
        };
        let placed = job.place();
        let truth = pool.install(|| TruthTracer::build(&placed.whole, placed.ignore_alpha));
        loop {
            job = jobs.try_iter().last().unwrap_or(job);
            if !job.is_of_the_same(&placed) {
                next = Some(job);
                break;
            }
            teller.tell(News::Traced(pool.install(|| trace(&truth, job.key))));
            match jobs.recv() {
                Ok(later) => job = later,
                Err(_) => return,
            }
        }
    }
}

fn trace(truth: &TruthTracer<'_>, key: TraceKey) -> Traced {
    let surfaces = truth.surfaces(&key.camera);
    Traced {
        key,
        sun: key.sun.map(|sun| truth.factors(&surfaces, sun, SunShape::Hard)),
        ambient: key.ambient.map(|(radius, rays)| truth.ambient(&surfaces, radius, rays)),
    }
}
