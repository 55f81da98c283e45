//! Keeps the visible shadow file in step with the sun: a given file if it was baked for it, a new bake
//! otherwise.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use adumbra_bake::MemoryCache;

use crate::baking::{BakeKey, RunningBake};
use crate::event::EventSender;
use crate::loaded_scene::LoadedScene;
use crate::settings::Settings;
use crate::shadow_file::ShownFile;

/// The shadow file and its bake.
pub(crate) struct Shadows {
    file: Option<ShownFile>,
    origin: Origin,
    running: Option<RunningBake>,
    given: Option<Given>,
    stopped: Option<Stopped>,
    max_memory_bytes: Option<u64>,
    /// Results of earlier bakes.
    cache: Arc<MemoryCache>,
    sender: EventSender,
}

/// A given file. It is kept while the sun is elsewhere, and used again when the sun returns.
struct Given {
    file: ShownFile,
    path: Option<PathBuf>,
    /// Whether a bake was requested in its place.
    is_set_aside: bool,
}

/// A bake that must not be started again.
struct Stopped {
    key: BakeKey,
    /// Why it failed; `None` if it was cancelled.
    fault: Option<String>,
}

/// The origin of the file.
enum Origin {
    /// There is no file, or it is to be replaced by a new bake.
    None,
    /// The file was given.
    Given,
    /// The file follows the sun.
    Followed,
    /// The file is a level of a bake, not necessarily the last one.
    Baked { key: BakeKey, is_last: bool },
}

impl Shadows {
    pub(crate) fn new(max_memory_bytes: Option<u64>, sender: EventSender) -> Self {
        Self {
            file: None,
            origin: Origin::None,
            running: None,
            given: None,
            stopped: None,
            max_memory_bytes,
            cache: Arc::default(),
            sender,
        }
    }

    /// Drops the file and its bake, for another scene.
    pub(crate) fn clear(&mut self) {
        *self = Self::new(self.max_memory_bytes, self.sender.clone());
    }

    /// Uses a file that was given.
    pub(crate) fn give(&mut self, file: ShownFile, path: Option<PathBuf>) {
        self.clear();
        self.given = Some(Given { file: file.clone(), path, is_set_aside: false });
        self.origin = Origin::Given;
        self.file = Some(file);
    }

    /// Uses the keys around a moving sun, which need no bake.
    pub(crate) fn follow(&mut self, file: ShownFile) {
        self.clear();
        self.origin = Origin::Followed;
        self.file = Some(file);
    }

    /// Requests a new bake, even if a file was given or the last bake was stopped. The existing file stays in
    /// use until the new bake has a level.
    pub(crate) fn rebake(&mut self) {
        (self.origin, self.stopped) = (Origin::None, None);
        self.set_aside(true);
    }

    /// Uses the given file again if it was baked for the current sun.
    pub(crate) fn return_to_given(&mut self) {
        self.set_aside(false);
    }

    fn set_aside(&mut self, is_set_aside: bool) {
        if let Some(given) = &mut self.given {
            given.is_set_aside = is_set_aside;
        }
    }

    /// Uses the given file again if it was baked for the current sun. Returns whether the file changed.
    fn take_back(&mut self, settings: &Settings) -> bool {
        let fits = |g: &&Given| !g.is_set_aside && g.file.serves(settings);
        let Some(given) = self.given.as_ref().filter(fits) else { return false };
        if matches!(self.origin, Origin::Given) {
            return false;
        }
        self.file = Some(given.file.clone());
        self.origin = Origin::Given;
        true
    }

    pub(crate) fn file(&self) -> Option<&ShownFile> {
        self.file.as_ref()
    }

    /// Whether the visible file is streamed or follows a moving sun, and the last frame lacked some of its
    /// data.
    pub(crate) fn is_streaming(&self, settings: &Settings) -> bool {
        self.file().is_some_and(|file| settings.uses_file() && !file.is_settled())
    }

    /// Returns the path of the visible file if it was given.
    pub(crate) fn given_path(&self, settings: &Settings) -> Option<&Path> {
        let is_shown = settings.uses_file() && matches!(self.origin, Origin::Given) && self.fits(settings);
        self.given.as_ref().filter(|_| is_shown)?.path.as_deref()
    }

    /// Returns why the visible bake failed, if it did.
    pub(crate) fn fault(&self, settings: &Settings, scene: &LoadedScene) -> Option<&str> {
        let wanted = BakeKey::new(scene.number, settings);
        let stopped = self.stopped.as_ref().filter(|s| settings.uses_file() && s.key == wanted)?;
        stopped.fault.as_deref()
    }

    /// The bake in progress.
    pub(crate) fn running(&self) -> Option<&RunningBake> {
        self.running.as_ref()
    }

    /// Whether the visible file is final and no bake is running.
    pub(crate) fn is_settled(&self, settings: &Settings, scene: &LoadedScene) -> bool {
        !self.needs_bake(settings, scene) && self.running.is_none()
    }

    /// Whether the visible file fits the settings, even if it is not final.
    pub(crate) fn has_landed(&self, settings: &Settings) -> bool {
        !settings.uses_file() || self.fits(settings)
    }

    fn fits(&self, settings: &Settings) -> bool {
        self.file().is_some_and(|f| f.serves(settings))
    }

    /// Whether a visible technique reads a file, the final file is not present, and its bake was not stopped.
    fn needs_bake(&self, settings: &Settings, scene: &LoadedScene) -> bool {
        let wanted = BakeKey::new(scene.number, settings);
        let is_final = match &self.origin {
            Origin::None => false,
            Origin::Followed => true,
            Origin::Given => self.fits(settings),
            Origin::Baked { key, is_last } => *is_last && *key == wanted,
        };
        let is_stopped = self.stopped.as_ref().is_some_and(|s| s.key == wanted);
        settings.uses_file() && !is_final && !is_stopped
    }

    /// Starts and cancels bakes until the visible file fits the settings. Only one bake runs at a time.
    /// Returns whether the file changed.
    pub(crate) fn reconcile(&mut self, settings: &Settings, scene: &Arc<LoadedScene>) -> bool {
        let has_changed = self.take_back(settings);
        let key = BakeKey::new(scene.number, settings);
        let wanted = self.needs_bake(settings, scene);
        match &self.running {
            Some(running) if !wanted || running.key != key => running.cancel(),
            None if wanted => {
                let sender = self.sender.clone();
                let cache = self.cache.clone();
                let scene = scene.clone();
                self.running = Some(RunningBake::start(key, scene, self.max_memory_bytes, cache, sender));
            }
            _ => {}
        }
        has_changed
    }

    /// Updates the progress of a bake.
    pub(crate) fn progress(&mut self, bake: u64, resolution: u64, share: f32) {
        if let Some(running) = self.running.as_mut().filter(|r| r.number == bake) {
            (running.resolution, running.share) = (resolution, share);
        }
    }

    /// Uses a level of a bake. Returns false if the settings no longer need it.
    pub(crate) fn landed(&mut self, bake: u64, file: ShownFile, is_last: bool, settings: &Settings) -> bool {
        let Some(running) = self.running.as_ref().filter(|r| r.number == bake) else { return false };
        let key = running.key;
        if is_last {
            self.running = None;
        }
        if key.sun != settings.sun {
            return false;
        }
        let is_finer =
            |old: &ShownFile| old.serves(settings) && old.settings().resolution > file.settings().resolution;
        if !is_last && self.file().is_some_and(is_finer) {
            // The first levels of a finer bake are coarser than the result of the previous bake.
            return false;
        }
        self.origin = Origin::Baked { key, is_last };
        self.file = Some(file);
        true
    }

    /// Ends a bake before its last level. A bake that failed is not started again.
    pub(crate) fn ended(&mut self, bake: u64, fault: Option<String>) {
        let Some(ended) = self.running.take_if(|r| r.number == bake) else { return };
        if fault.is_some() {
            self.stopped = Some(Stopped { key: ended.key, fault });
        }
    }

    /// Stops the bake of these settings for good; completed levels stay. Returns false if there is nothing to
    /// stop.
    pub(crate) fn cancel(&mut self, settings: &Settings, scene: &LoadedScene) -> bool {
        let wanted = self.needs_bake(settings, scene);
        if let Some(running) = &self.running {
            running.cancel();
        }
        if wanted {
            let key = BakeKey::new(scene.number, settings);
            self.stopped = Some(Stopped { key, fault: None });
        }
        wanted
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{self, Receiver};

    use adumbra::Sun;
    use adumbra_scene::{GeneratedKind, generate};

    use super::*;
    use crate::event::Event;
    use crate::settings::tests::settings;
    use crate::shadow_file::is_same_sun;

    struct Bench {
        shadows: Shadows,
        scene: Arc<LoadedScene>,
        settings: Settings,
        events: Receiver<Event>,
    }

    impl Bench {
        fn new() -> Self {
            let (channel, events) = mpsc::channel();
            // The thread of a dropped bake may outlive the receiver.
            let sender = EventSender::new(move |event| drop(channel.send(event)));
            let scene = generate(GeneratedKind::Primitives, 1);
            let scene = Arc::new(LoadedScene::new("primitives".into(), scene, false));
            let settings = Settings { resolution: 2048, ..settings() };
            Self { shadows: Shadows::new(None, sender), scene, settings, events }
        }

        /// Handles events until no bake is running and none is to be started.
        fn settle(&mut self) {
            self.shadows.reconcile(&self.settings, &self.scene);
            while !self.shadows.is_settled(&self.settings, &self.scene) {
                match self.events.recv_timeout(std::time::Duration::from_secs(60)).unwrap() {
                    Event::Baked { bake, file, last } => {
                        self.shadows.landed(bake, ShownFile::whole(*file), last, &self.settings);
                    }
                    Event::BakeEnded { bake, error } => self.shadows.ended(bake, error),
                    _ => {}
                }
                self.shadows.reconcile(&self.settings, &self.scene);
            }
        }

        fn resolution(&self) -> u32 {
            self.shadows.file().map_or(0, |file| file.settings().resolution)
        }
    }

    #[test]
    fn shadows_follow_the_sun_there_and_back() {
        let mut bench = Bench::new();
        let first = bench.settings.sun;
        bench.settle();
        assert_eq!(bench.resolution(), 2048);
        let second = Sun::from_angles(200.0, 20.0).unwrap();
        for sun in [second, first, second, first] {
            // Started but not awaited: its results arrive when the sun is a different one.
            bench.settings.sun = sun;
            bench.shadows.reconcile(&bench.settings, &bench.scene);
        }
        bench.settings.sun = second;
        bench.settle();
        assert!(bench.shadows.has_landed(&bench.settings));
        let file = bench.shadows.file().unwrap();
        assert!(is_same_sun(&file.sun(), &second) && bench.resolution() == 2048);
    }

    #[test]
    fn given_shadows_stay_until_a_bake_is_requested() {
        let mut bench = Bench::new();
        bench.settings.resolution = 512;
        bench.settle();
        let file = bench.shadows.file().unwrap().clone();
        bench.settings.resolution = 2048;
        bench.shadows.give(file, Some("given.adumbra".into()));
        bench.settle();
        assert_eq!(bench.resolution(), 512);
        assert_eq!(bench.shadows.given_path(&bench.settings), Some(Path::new("given.adumbra")));
        // The sun moves away and returns.
        let first = std::mem::replace(&mut bench.settings.sun, Sun::from_angles(10.0, 60.0).unwrap());
        bench.settle();
        assert_eq!(bench.resolution(), 2048);
        assert_eq!(bench.shadows.given_path(&bench.settings), None);
        bench.settings.sun = first;
        assert!(bench.shadows.reconcile(&bench.settings, &bench.scene), "the file is another");
        assert_eq!(bench.resolution(), 512);
        assert_eq!(bench.shadows.given_path(&bench.settings), Some(Path::new("given.adumbra")));
        assert!(!bench.shadows.reconcile(&bench.settings, &bench.scene));
        bench.shadows.rebake();
        bench.settle();
        assert!(bench.resolution() == 2048 && bench.shadows.given_path(&bench.settings).is_none());
        bench.shadows.return_to_given();
        bench.settle();
        assert_eq!(bench.resolution(), 512);
    }

    #[test]
    fn a_bake_that_fails_is_reported_and_not_started_again() {
        let mut bench = Bench::new();
        // Less than any bake needs.
        bench.shadows.max_memory_bytes = Some(1);
        bench.settings.resolution = 1 << 17;
        bench.settle();
        assert!(bench.shadows.fault(&bench.settings, &bench.scene).is_some());
        bench.shadows.max_memory_bytes = None;
        bench.settings.resolution = 512;
        bench.settle();
        assert_eq!(bench.shadows.fault(&bench.settings, &bench.scene), None);
    }

    #[test]
    fn cancelled_bake_keeps_its_completed_levels() {
        let mut bench = Bench::new();
        bench.settle();
        bench.settings.resolution = 1 << 17;
        bench.shadows.reconcile(&bench.settings, &bench.scene);
        assert!(
            bench.shadows.running().is_some() && !bench.shadows.is_settled(&bench.settings, &bench.scene)
        );
        assert!(bench.shadows.cancel(&bench.settings, &bench.scene));
        bench.settle();
        assert!((512..1 << 17).contains(&bench.resolution()));
        assert!(!bench.shadows.cancel(&bench.settings, &bench.scene));
    }
}
