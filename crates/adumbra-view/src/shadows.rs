//! Keeps the shadow files that are seen in step with the sun: given ones as long as it stands where they say, baked ones otherwise.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use adumbra::format::AnyFile;

use crate::baking::{BakeKey, FileKind, RunningBake};
use crate::loading::LoadedScene;
use crate::news::Teller;
use crate::settings::Settings;
use crate::shadow_file::serves;
use crate::stage::Files;

/// Files and bakes of both kinds.
pub(crate) struct Shadows {
    pub(crate) files: Files,
    kinds: [Kind; 2],
    max_memory_bytes: Option<u64>,
    teller: Teller,
}

#[derive(Default)]
struct Kind {
    running: Option<RunningBake>,
    origin: Origin,
    given: Option<Given>,
    stopped: Option<Stopped>,
}

/// A file that was given, kept for when the sun comes back to where it says.
struct Given {
    file: Arc<AnyFile>,
    path: Option<PathBuf>,
    /// A bake was asked for in its place.
    is_set_aside: bool,
}

/// A bake that is not begun again.
struct Stopped {
    key: BakeKey,
    /// Why it failed; none where it was cancelled.
    fault: Option<String>,
}

/// Where a file comes from.
#[derive(Default)]
enum Origin {
    /// There is none, or what there is is to be baked anew.
    #[default]
    None,
    /// It was given.
    Given,
    /// A level of a bake, the last one or an earlier.
    Baked { key: BakeKey, is_last: bool },
}

const KINDS: [FileKind; 2] = [FileKind::Light, FileKind::Tree];

/// Whether a technique that is seen looks up in such a file.
fn is_used(kind: FileKind, settings: &Settings) -> bool {
    match kind {
        FileKind::Light => settings.uses("voxel") || settings.uses("voxel+csm"),
        FileKind::Tree => settings.uses("voxel-*"),
    }
}

fn set_aside(state: &mut Kind, is_set_aside: bool) {
    if let Some(given) = &mut state.given {
        given.is_set_aside = is_set_aside;
    }
}

impl Shadows {
    pub(crate) fn new(max_memory_bytes: Option<u64>, teller: Teller) -> Self {
        Self { files: Files::default(), kinds: Default::default(), max_memory_bytes, teller }
    }

    /// Another scene: nothing of this one is right any more.
    pub(crate) fn clear(&mut self) {
        self.files = Files::default();
        self.kinds = Default::default();
    }

    /// Takes a file that was given.
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

    /// Has everything baked anew, given files and what was stopped too; what there is stays until then.
    pub(crate) fn rebake(&mut self) {
        for state in &mut self.kinds {
            (state.origin, state.stopped) = (Origin::None, None);
            set_aside(state, true);
        }
    }

    /// Has given files taken again wherever the sun stands where they say.
    pub(crate) fn return_to_given(&mut self) {
        self.kinds.iter_mut().for_each(|state| set_aside(state, false));
    }

    /// Takes a given file again where the sun has come back to it.
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

    /// Where the files lie that are shown, as far as they were given.
    pub(crate) fn given_paths(&self, settings: &Settings) -> Vec<&Path> {
        let shown = |kind: &FileKind| {
            let Kind { origin, given, .. } = &self.kinds[*kind as usize];
            let is_right = self.file(*kind).is_some_and(|f| serves(f, settings));
            let given = given.as_ref().filter(|_| matches!(origin, Origin::Given) && is_right)?;
            given.path.as_deref()
        };
        KINDS.iter().filter(|kind| is_used(**kind, settings)).filter_map(shown).collect()
    }

    /// Why what is seen of bakes failed, where it did.
    pub(crate) fn fault(&self, settings: &Settings, scene: &LoadedScene) -> Option<&str> {
        KINDS.iter().filter(|kind| is_used(**kind, settings)).find_map(|&kind| {
            let wanted = BakeKey::new(kind, scene.number, settings);
            let stopped = self.kinds[kind as usize].stopped.as_ref().filter(|s| s.key == wanted)?;
            stopped.fault.as_deref()
        })
    }

    /// The bakes that run.
    pub(crate) fn running(&self) -> impl Iterator<Item = &RunningBake> {
        self.kinds.iter().filter_map(|k| k.running.as_ref())
    }

    /// Whether everything that is seen is as it will be.
    pub(crate) fn is_settled(&self, settings: &Settings, scene: &LoadedScene) -> bool {
        KINDS.iter().all(|&kind| !is_used(kind, settings) || self.is_done(kind, settings, scene))
            && self.running().next().is_none()
    }

    /// Whether there is something right of everything that is seen.
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
            Origin::Baked { key, is_last } => *is_last && key.serves(&wanted),
        };
        is_there || stopped.as_ref().is_some_and(|s| s.key == wanted)
    }

    /// Begins and ends bakes, so that what is seen comes to be right. One bake of a kind runs at a time. True where files changed.
    pub(crate) fn reconcile(&mut self, settings: &Settings, scene: &Arc<LoadedScene>) -> bool {
        let mut has_changed = false;
        for kind in KINDS {
            has_changed |= self.take_back(kind, settings);
            let key = BakeKey::new(kind, scene.number, settings);
            let wanted = is_used(kind, settings) && !self.is_done(kind, settings, scene);
            let state = &mut self.kinds[kind as usize];
            match &state.running {
                Some(running) if !wanted || !running.key.serves(&key) => running.cancel(),
                None if wanted => {
                    let teller = self.teller.clone();
                    state.running =
                        Some(RunningBake::start(key, scene.clone(), self.max_memory_bytes, teller));
                }
                _ => {}
            }
        }
        has_changed
    }

    fn running_mut(&mut self, bake: u64) -> Option<&mut Kind> {
        self.kinds.iter_mut().find(|k| k.running.as_ref().is_some_and(|r| r.number == bake))
    }

    /// Where a bake stands.
    pub(crate) fn progress(&mut self, bake: u64, resolution: u64, share: f32) {
        if let Some(running) = self.running_mut(bake).and_then(|k| k.running.as_mut()) {
            (running.resolution, running.share) = (resolution, share);
        }
    }

    /// Takes a level of a bake. False where it is not what is wanted any more.
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
            // A finer bake begins with what is coarser than the one before it.
            return false;
        }
        self.kinds[key.kind as usize].origin = Origin::Baked { key, is_last };
        *self.file_mut(key.kind) = Some(Arc::new(file));
        true
    }

    /// A bake ended without its last level; one that failed is not begun again.
    pub(crate) fn ended(&mut self, bake: u64, fault: Option<String>) {
        let Some(state) = self.running_mut(bake) else { return };
        let ended = state.running.take();
        if let (Some(RunningBake { key, .. }), Some(_)) = (&ended, &fault) {
            state.stopped = Some(Stopped { key: *key, fault });
        }
    }

    /// Stops for good what these settings would have baked; what landed stays. False where there is nothing to stop.
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

    use adumbra::light::Sun;
    use adumbra::scene::{GeneratedKind, generate};

    use super::*;
    use crate::news::News;
    use crate::settings::tests::settings;
    use crate::shadow_file::{is_same_sun, sun_of};

    struct Bench {
        shadows: Shadows,
        scene: Arc<LoadedScene>,
        settings: Settings,
        told: Receiver<News>,
    }

    impl Bench {
        fn new() -> Self {
            let (tell, told) = mpsc::channel();
            // The thread of a bake that was dropped tells nobody.
            let teller = Teller::new(move |news| drop(tell.send(news)));
            let scene = generate(GeneratedKind::Primitives, 1);
            let scene = Arc::new(LoadedScene::new("primitives".into(), scene, false));
            let settings = Settings { resolution: 2048, ..settings() };
            Self { shadows: Shadows::new(None, teller), scene, settings, told }
        }

        /// Takes news until nothing runs and nothing is to be begun.
        fn settle(&mut self) {
            self.shadows.reconcile(&self.settings, &self.scene);
            while !self.shadows.is_settled(&self.settings, &self.scene) {
                match self.told.recv_timeout(std::time::Duration::from_secs(60)).unwrap() {
                    News::Baked { bake, file, last } => {
                        self.shadows.landed(bake, file, last, &self.settings);
                    }
                    News::BakeEnded { bake, error } => self.shadows.ended(bake, error),
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
            // Begun and not waited for: what lands later is of another sun.
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
        // The sun goes away and comes back.
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
    fn a_bake_that_fails_is_told_and_not_begun_again() {
        let mut bench = Bench::new();
        // Less than any bake holds.
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
