//! Ray tracing on another thread: the true visibility at each pixel, for the technique and the ambient
//! occlusion named `truth`.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;

use adumbra_compare::truth::{SunShape, TruthTracer};
use adumbra_scene::Scene;
use adumbra_truth::movers::BallPath;

use crate::background::{background_pool, caught};
use crate::event::{Event, EventSender};
use crate::loaded_scene::LoadedScene;
use crate::traced::{TraceKey, Traced};

struct Job {
    key: TraceKey,
    scene: Arc<LoadedScene>,
    ball: Option<BallPath>,
    cancel: Arc<AtomicBool>,
}

impl Job {
    /// Whether both have the same geometry.
    fn is_of_the_same(&self, other: &Placed) -> bool {
        (self.key.scene, self.key.seconds) == (other.scene, other.seconds)
    }

    /// Returns the scene posed for the job's time.
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

/// A scene posed for a point in time.
struct Placed {
    scene: [u64; 2],
    seconds: f64,
    whole: Arc<Scene>,
    ignore_alpha: bool,
}

/// The tracing thread. It traces the picture requested last. Older requests are dropped, even if they are in
/// progress.
pub(crate) struct TraceThread {
    jobs: Sender<Job>,
    asked: Option<(TraceKey, Arc<AtomicBool>)>,
}

impl TraceThread {
    pub(crate) fn start(sender: EventSender) -> Self {
        let (jobs, received) = mpsc::channel();
        thread::spawn(move || trace_all(&received, &sender));
        Self { jobs, asked: None }
    }

    /// Requests a picture. Returns false if it is the one requested last. The key's time determines the pose
    /// of everything that moves, including the ball.
    pub(crate) fn ask(&mut self, key: TraceKey, scene: &Arc<LoadedScene>, ball: Option<&BallPath>) -> bool {
        if self.asked.as_ref().is_some_and(|(asked, _)| *asked == key) {
            return false;
        }
        self.cancel();
        let cancel = Arc::new(AtomicBool::new(false));
        self.asked = Some((key, cancel.clone()));
        // The thread lives as long as `self`.
        let _ = self.jobs.send(Job { key, scene: scene.clone(), ball: ball.cloned(), cancel });
        true
    }

    /// Makes the current job end soon, without an event.
    pub(crate) fn cancel(&mut self) {
        if let Some((_, cancel)) = self.asked.take() {
            cancel.store(true, Ordering::Relaxed);
        }
    }
}

impl Drop for TraceThread {
    fn drop(&mut self) {
        self.cancel();
    }
}

fn trace_all(jobs: &Receiver<Job>, sender: &EventSender) {
    let mut next = jobs.recv().ok();
    while let Some(job) = next.take() {
        next = match caught(|| trace_scene(job, jobs, sender)) {
            Ok(other) => other,
            Err(error) => {
                sender.send(Event::NotTraced { error });
                jobs.recv().ok()
            }
        };
    }
}

/// Traces pictures of one scene. Returns the first job of another scene, or `None` if no more jobs can
/// arrive.
fn trace_scene(mut job: Job, jobs: &Receiver<Job>, sender: &EventSender) -> Result<Option<Job>, String> {
    let pool = background_pool()?;
    let placed = job.place();
    let truth = pool.install(|| TruthTracer::build(&placed.whole, placed.ignore_alpha));
    loop {
        job = jobs.try_iter().last().unwrap_or(job);
        if !job.is_of_the_same(&placed) {
            return Ok(Some(job));
        }
        let traced = pool.install(|| trace(&truth, job.key, &job.cancel));
        if !job.cancel.load(Ordering::Relaxed) {
            sender.send(Event::Traced(traced));
        }
        match jobs.recv() {
            Ok(later) => job = later,
            Err(_) => return Ok(None),
        }
    }
}

fn trace(truth: &TruthTracer<'_>, key: TraceKey, cancel: &AtomicBool) -> Traced {
    let surfaces = truth.surfaces_unless(&key.camera, cancel);
    let sun = key.sun.map(|sun| truth.factors_unless(&surfaces, sun, SunShape::Hard, cancel));
    let ambient = key.ambient.map(|(radius, rays)| truth.ambient_unless(&surfaces, radius, rays, cancel));
    Traced { key, sun, ambient }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::time::{Duration, Instant};

    use adumbra_scene::{Camera, GeneratedKind, generate};

    use super::*;

    fn thread() -> (TraceThread, Receiver<Event>) {
        let (channel, events) = mpsc::channel();
        (TraceThread::start(EventSender::new(move |event| drop(channel.send(event)))), events)
    }

    fn loaded(scene: Scene) -> Arc<LoadedScene> {
        Arc::new(LoadedScene::new(PathBuf::from("scene"), scene, false))
    }

    fn key(scene: &Arc<LoadedScene>, rays: u32) -> TraceKey {
        let camera = Camera { width: 320, height: 180, ..Camera::overview(&scene.whole.bounds(), 45.0) };
        let ambient = Some((1.0, rays));
        TraceKey { scene: [scene.number, 0], camera, seconds: 0.0, sun: Some([0.0, 1.0, 0.0]), ambient }
    }

    #[test]
    fn a_newer_picture_does_not_wait_for_an_older_one() {
        let scene = loaded(generate(GeneratedKind::Primitives, 1));
        let (mut thread, events) = thread();
        let quick = key(&scene, 1);
        // Takes minutes to trace.
        assert!(thread.ask(key(&scene, 1_000_000), &scene, None));
        std::thread::sleep(Duration::from_millis(200));
        let begun = Instant::now();
        assert!(thread.ask(quick, &scene, None) && !thread.ask(quick, &scene, None));
        let Ok(Event::Traced(traced)) = events.recv_timeout(Duration::from_secs(60)) else {
            panic!("no picture")
        };
        assert!(traced.key == quick && begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
        // A cancelled picture never arrives, and may be requested again.
        assert!(thread.ask(key(&scene, 1_000_000), &scene, None));
        thread.cancel();
        assert!(thread.ask(quick, &scene, None));
        let Ok(Event::Traced(traced)) = events.recv_timeout(Duration::from_secs(60)) else {
            panic!("no picture")
        };
        assert!(traced.key == quick);
    }

    #[test]
    fn a_panic_is_reported_and_the_next_scene_is_traced() {
        let mut broken = generate(GeneratedKind::Primitives, 1);
        broken.meshes[0].triangles[0][0] = u32::MAX;
        let sound = loaded(generate(GeneratedKind::Primitives, 1));
        let whole = Arc::new(broken);
        let other = LoadedScene::new(PathBuf::from("broken"), generate(GeneratedKind::Primitives, 1), false);
        let broken = Arc::new(LoadedScene { whole, ..other });
        let (mut thread, events) = thread();
        assert!(thread.ask(TraceKey { scene: [broken.number, 0], ..key(&sound, 1) }, &broken, None));
        let Ok(Event::NotTraced { error }) = events.recv_timeout(Duration::from_secs(60)) else {
            panic!("no event")
        };
        assert!(error.contains("please report it"), "{error}");
        assert!(thread.ask(key(&sound, 1), &sound, None));
        assert!(matches!(events.recv_timeout(Duration::from_secs(60)), Ok(Event::Traced(_))));
    }
}
