//! Keeps the visible shadow files in step with the sun: given files if they were baked for it, new bakes otherwise.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use adumbra_render::Reads;
use adumbra_tree::AnyFile;

use crate::baking::{BakeKey, FileKind, RunningBake};
use crate::event::EventSender;
use crate::loaded_scene::LoadedScene;
use crate::settings::Settings;
use crate::shadow_file::serves;
use crate::stage::Files;

/// Files and bakes of both kinds.
pub(crate) struct Shadows {
    pub(crate) files: Files,
    kinds: [Kind; 2],
    max_memory_bytes: Option<u64>,
    sender: EventSender,
}

#[derive(Default)]
struct Kind {
    running: Option<RunningBake>,
    origin: Origin,
    given: Option<Given>,
    stopped: Option<Stopped>,
}

/// A given file, kept for when the sun is again the one it was baked for.
struct Given {
    file: Arc<AnyFile>,
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

/// The origin of a file.
#[derive(Default)]
enum Origin {
    /// There is no file, or it is to be replaced by a new bake.
    #[default]
    None,
    /// The file was given.
    Given,
    /// The file is a level of a bake, not necessarily the last one.
    Baked { key: BakeKey, is_last: bool },
}

const KINDS: [FileKind; 2] = [FileKind::Light, FileKind::Tree];

/// Whether a visible technique reads a file of this kind.
pub(crate) fn is_used(kind: FileKind, settings: &Settings) -> bool {
    match kind {
        FileKind::Light => settings.seen().iter().any(|s| s.reads().is_light_file()),
        FileKind::Tree => settings.seen().iter().any(|s| s.reads() == Reads::TreeFile),
    }
}

fn set_aside(state: &mut Kind, is_set_aside: bool) {
    if let Some(given) = &mut state.given {
        given.is_set_aside = is_set_aside;
    }
}

impl Shadows {
    pub(crate) fn new(max_memory_bytes: Option<u64>, sender: EventSender) -> Self {
        Self { files: Files::default(), kinds: Default::default(), max_memory_bytes, sender }
    }

    /// Drops all files and bakes, because there is another scene.
    pub(crate) fn clear(&mut self) {
        self.files = Files::default();
        self.kinds = Default::default();
    }

    /// Uses a file that was given.
    pub(crate) fn give(&mut self, file: AnyFile, path: Option<PathBuf>) {
        let kind = match file {
            AnyFile::Light(_) => FileKind::Light,
            AnyFile::Tree(_) => FileKind::Tree,
        };
        let file = Arc::new(file);
        let given = Given { file: file.clone(), path, is_set_aside: false };
        self.kinds[kind as usize] = Kind { origin: Origin::Given, given: Some(given), ..Kind::default() };
        *self.file_mut(kind) = Some(file);
    }

    /// Requests new bakes of everything, including given files and bakes that were stopped. Existing files stay in use
    /// until then.
    pub(crate) fn rebake(&mut self) {
        for state in &mut self.kinds {
            (state.origin, state.stopped) = (Origin::None, None);
            set_aside(state, true);
        }
    }

    /// Uses given files again if they were baked for the current sun.
    pub(crate) fn return_to_given(&mut self) {
        self.kinds.iter_mut().for_each(|state| set_aside(state, false));
    }

    /// Uses a given file again if it was baked for the current sun. Returns whether the file changed.
    fn take_back(&mut self, kind: FileKind, settings: &Settings) -> bool {
        let state = &mut self.kinds[kind as usize];
        let fits = |g: &&Given| !g.is_set_aside && serves(&g.file, settings);
        let Some(given) = state.given.as_ref().filter(fits) else { return false };
        if matches!(state.origin, Origin::Given) {
            return false;
        }
        let file = given.file.clone();
        state.origin = Origin::Given;
        *self.file_mut(kind) = Some(file);
        true
    }

    fn file_mut(&mut self, kind: FileKind) -> &mut Option<Arc<AnyFile>> {
        match kind {
            FileKind::Light => &mut self.files.light,
            FileKind::Tree => &mut self.files.tree,
        }
    }

    pub(crate) fn file(&self, kind: FileKind) -> Option<&Arc<AnyFile>> {
        match kind {
            FileKind::Light => self.files.light.as_ref(),
            FileKind::Tree => self.files.tree.as_ref(),
        }
    }

    /// Returns the paths of those visible files that were given.
    pub(crate) fn given_paths(&self, settings: &Settings) -> Vec<&Path> {
        let shown = |kind: &FileKind| {
            let Kind { origin, given, .. } = &self.kinds[*kind as usize];
            let is_right = self.file(*kind).is_some_and(|f| serves(f, settings));
            let given = given.as_ref().filter(|_| matches!(origin, Origin::Given) && is_right)?;
            given.path.as_deref()
        };
        KINDS.iter().filter(|kind| is_used(**kind, settings)).filter_map(shown).collect()
    }

    /// Returns why a visible bake failed, if one did.
    pub(crate) fn fault(&self, settings: &Settings, scene: &LoadedScene) -> Option<&str> {
        KINDS.iter().filter(|kind| is_used(**kind, settings)).find_map(|&kind| {
            let wanted = BakeKey::new(kind, scene.number, settings);
            let stopped = self.kinds[kind as usize].stopped.as_ref().filter(|s| s.key == wanted)?;
            stopped.fault.as_deref()
        })
    }

    /// The bakes in progress.
    pub(crate) fn running(&self) -> impl Iterator<Item = &RunningBake> {
        self.kinds.iter().filter_map(|k| k.running.as_ref())
    }

    /// Whether all visible files are final.
    pub(crate) fn is_settled(&self, settings: &Settings, scene: &LoadedScene) -> bool {
        KINDS.iter().all(|&kind| !is_used(kind, settings) || self.is_done(kind, settings, scene))
            && self.running().next().is_none()
    }

    /// Whether all visible files fit the settings, even if they are not final.
    pub(crate) fn has_landed(&self, settings: &Settings) -> bool {
        let is_right = |kind| self.file(kind).is_some_and(|f| serves(f, settings));
        KINDS.iter().all(|&kind| !is_used(kind, settings) || is_right(kind))
    }

    fn is_done(&self, kind: FileKind, settings: &Settings, scene: &LoadedScene) -> bool {
        let wanted = BakeKey::new(kind, scene.number, settings);
        let Kind { origin, stopped, .. } = &self.kinds[kind as usize];
        let is_there = match origin {
            Origin::None => false,
            Origin::Given => self.file(kind).is_some_and(|f| serves(f, settings)),
            Origin::Baked { key, is_last } => *is_last && *key == wanted,
        };
        is_there || stopped.as_ref().is_some_and(|s| s.key == wanted)
    }

    /// Starts and cancels bakes until the visible files fit the settings. Only one bake of each kind runs at a time.
    /// Returns whether files changed.
    pub(crate) fn reconcile(&mut self, settings: &Settings, scene: &Arc<LoadedScene>) -> bool {
        let mut has_changed = false;
        for kind in KINDS {
            has_changed |= self.take_back(kind, settings);
            let key = BakeKey::new(kind, scene.number, settings);
            let wanted = is_used(kind, settings) && !self.is_done(kind, settings, scene);
            let state = &mut self.kinds[kind as usize];
            match &state.running {
                Some(running) if !wanted || running.key != key => running.cancel(),
                None if wanted => {
                    let sender = self.sender.clone();
                    state.running =
                        Some(RunningBake::start(key, scene.clone(), self.max_memory_bytes, sender));
                }
                _ => {}
            }
        }
        has_changed
    }

    fn running_mut(&mut self, bake: u64) -> Option<&mut Kind> {
        self.kinds.iter_mut().find(|k| k.running.as_ref().is_some_and(|r| r.number == bake))
    }

    /// Updates the progress of a bake.
    pub(crate) fn progress(&mut self, bake: u64, resolution: u64, share: f32) {
        if let Some(running) = self.running_mut(bake).and_then(|k| k.running.as_mut()) {
            (running.resolution, running.share) = (resolution, share);
        }
    }

    /// Uses a level of a bake. Returns false if the settings no longer need it.
    pub(crate) fn landed(&mut self, bake: u64, file: AnyFile, is_last: bool, settings: &Settings) -> bool {
        let Some(state) = self.running_mut(bake) else { return false };
        let Some(key) = state.running.as_ref().map(|r| r.key) else { return false };
        if is_last {
            state.running = None;
        }
        if key.sun != settings.sun {
            return false;
        }
        let side = |file: &AnyFile| match file {
            AnyFile::Light(file) => file.settings.resolution,
            AnyFile::Tree(file) => file.space.side_voxels(),
        };
        let is_finer = |old: &Arc<AnyFile>| serves(old, settings) && side(old) > side(&file);
        if !is_last && self.file(key.kind).is_some_and(is_finer) {
            // The first levels of a finer bake are coarser than the result of the previous bake.
            return false;
        }
        self.kinds[key.kind as usize].origin = Origin::Baked { key, is_last };
        *self.file_mut(key.kind) = Some(Arc::new(file));
        true
    }

    /// Ends a bake before its last level. A bake that failed is not started again.
    pub(crate) fn ended(&mut self, bake: u64, fault: Option<String>) {
        let Some(state) = self.running_mut(bake) else { return };
        let ended = state.running.take();
        if let (Some(RunningBake { key, .. }), Some(_)) = (&ended, &fault) {
            state.stopped = Some(Stopped { key: *key, fault });
        }
    }

    /// Stops the bakes of these settings for good; completed levels stay. Returns false if there is nothing to stop.
    pub(crate) fn cancel(&mut self, settings: &Settings, scene: &LoadedScene) -> bool {
        let mut stopped = false;
        for kind in KINDS {
            let wanted = is_used(kind, settings) && !self.is_done(kind, settings, scene);
            let state = &mut self.kinds[kind as usize];
            if let Some(running) = &state.running {
                running.cancel();
            }
            if wanted {
                stopped = true;
                let key = BakeKey::new(kind, scene.number, settings);
                state.stopped = Some(Stopped { key, fault: None });
            }
        }
        stopped
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
    use crate::shadow_file::{is_same_sun, sun_of};

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
                        self.shadows.landed(bake, file, last, &self.settings);
                    }
                    Event::BakeEnded { bake, error } => self.shadows.ended(bake, error),
                    _ => {}
                }
                self.shadows.reconcile(&self.settings, &self.scene);
            }
        }

        fn resolution(&self) -> u32 {
            match self.shadows.file(FileKind::Light).map(|f| &**f) {
                Some(AnyFile::Light(file)) => file.settings.resolution,
                _ => 0,
            }
        }
    }

    #[test]
    fn shadows_follow_the_sun_and_come_back() {
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
        let file = bench.shadows.file(FileKind::Light).unwrap();
        assert!(is_same_sun(&sun_of(file), &second) && bench.resolution() == 2048);
    }

    #[test]
    fn shadows_that_are_given_stay_until_a_bake_is_asked_for() {
        let mut bench = Bench::new();
        bench.settings.resolution = 512;
        bench.settle();
        let file = (**bench.shadows.file(FileKind::Light).unwrap()).clone();
        bench.settings.resolution = 2048;
        bench.shadows.give(file, Some("given.adumbra".into()));
        bench.settle();
        assert_eq!(bench.resolution(), 512);
        assert_eq!(bench.shadows.given_paths(&bench.settings), [Path::new("given.adumbra")]);
        // The sun moves away and returns.
        let first = std::mem::replace(&mut bench.settings.sun, Sun::from_angles(10.0, 60.0).unwrap());
        bench.settle();
        assert_eq!(bench.resolution(), 2048);
        assert!(bench.shadows.given_paths(&bench.settings).is_empty());
        bench.settings.sun = first;
        assert!(bench.shadows.reconcile(&bench.settings, &bench.scene), "the file is another");
        assert_eq!(bench.resolution(), 512);
        assert_eq!(bench.shadows.given_paths(&bench.settings), [Path::new("given.adumbra")]);
        assert!(!bench.shadows.reconcile(&bench.settings, &bench.scene));
        bench.shadows.rebake();
        bench.settle();
        assert!(bench.resolution() == 2048 && bench.shadows.given_paths(&bench.settings).is_empty());
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
    fn shadows_keep_what_landed_when_a_bake_is_cancelled() {
        let mut bench = Bench::new();
        bench.settle();
        bench.settings.resolution = 1 << 17;
        bench.shadows.reconcile(&bench.settings, &bench.scene);
        assert!(
            bench.shadows.running().count() == 1 && !bench.shadows.is_settled(&bench.settings, &bench.scene)
        );
        assert!(bench.shadows.cancel(&bench.settings, &bench.scene));
        bench.settle();
        assert!((512..1 << 17).contains(&bench.resolution()));
        assert!(!bench.shadows.cancel(&bench.settings, &bench.scene));
    }
}
