//! A bake behind the window, coarse to fine: each level is shown as it lands, and cancelling keeps the last.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::thread;

use adumbra::Error;
use adumbra::bake::{self, Options, Size};
use adumbra::format::{AnyFile, Layout, ShadowFile, TreeBody, TreeFile};
use adumbra::light::Sun;
use adumbra::scene::Scene;
use adumbra::tree::{TreeOptions, bake_tree};

use crate::background::{background_pool, caught};
use crate::loading::LoadedScene;
use crate::news::{News, Teller};
use crate::settings::Settings;

/// The coarsest level, texels on the longest side.
const COARSEST: u64 = 512;
/// A level is so many times as fine as the one before.
const STEP: u64 = 4;
/// The finest world-aligned tree, voxels a side.
const FINEST_TREE: u64 = 2048;

/// Which kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    /// Light-aligned, for `voxel` and `voxel+csm`.
    Light,
    /// World-aligned, for `voxel-cubes` and `voxel-texture`.
    Tree,
}

/// What a bake is of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BakeKey {
    pub(crate) kind: FileKind,
    /// Number of the scene.
    pub(crate) scene: u64,
    pub(crate) sun: Sun,
    /// Texels or voxels of the finest level.
    pub(crate) resolution: u64,
    /// Of light-aligned files.
    pub(crate) layout: Layout,
}

/// A bake that runs.
pub(crate) struct RunningBake {
    /// Its number: another bake of the same key has another.
    pub(crate) number: u64,
    pub(crate) key: BakeKey,
    /// Of the level that is baked now.
    pub(crate) resolution: u64,
    pub(crate) share: f32,
    cancel: Arc<AtomicBool>,
}

impl BakeKey {
    /// What these settings ask for.
    pub(crate) fn new(kind: FileKind, scene: u64, settings: &Settings) -> Self {
        let (resolution, layout) = match kind {
            FileKind::Light if settings.uses_penumbrae() => (settings.resolution, Layout::Hierarchy),
            FileKind::Light => (settings.resolution, Layout::default()),
            FileKind::Tree => (settings.resolution.min(FINEST_TREE), Layout::default()),
        };
        Self { kind, scene, sun: settings.sun, resolution, layout }
    }

    /// Whether what this key bakes does where `wanted` is asked for.
    pub(crate) fn serves(&self, wanted: &Self) -> bool {
        let as_wanted = Self { layout: wanted.layout, ..*self };
        as_wanted == *wanted && (self.layout == wanted.layout || self.layout == Layout::Hierarchy)
    }
}

/// The resolutions of the levels, coarse to fine.
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
    /// Starts a bake.
    pub(crate) fn start(
        key: BakeKey,
        scene: Arc<LoadedScene>,
        max_memory: Option<u64>,
        teller: Teller,
    ) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let cancel = Arc::new(AtomicBool::new(false));
        let seen = cancel.clone();
        thread::spawn(move || {
            let outcome = caught(|| {
                let pool = background_pool()?;
                pool.install(|| bake_levels(number, key, &scene, max_memory, &seen, &teller))
                    .map_err(|e| e.to_string())
            });
            if let Err(error) = outcome {
                let error = (!seen.load(Ordering::Relaxed)).then_some(error);
                teller.tell(News::BakeEnded { bake: number, error });
            }
        });
        Self { number, key, resolution: levels(key.resolution)[0], share: 0.0, cancel }
    }

    /// Has it stop soon.
    pub(crate) fn cancel(&self) {
        self.cancel.store(true, Ordering::Relaxed);
    }
}

impl Drop for RunningBake {
    fn drop(&mut self) {
        self.cancel();
    }
}

fn bake_levels(
    bake: u64,
    key: BakeKey,
    scene: &LoadedScene,
    max_memory: Option<u64>,
    cancel: &AtomicBool,
    teller: &Teller,
) -> adumbra::Result<()> {
    for resolution in levels(key.resolution) {
        // Each percent once: the window draws its panel for each.
        let told = AtomicU32::new(0);
        let tell = |share: f64| {
            let percent = (100.0 * share) as u32;
            if told.fetch_max(percent, Ordering::Relaxed) < percent {
                teller.tell(News::Baking { bake, resolution, share: share as f32 });
            }
        };
        let file = match key.kind {
            FileKind::Light => {
                let options = Options {
                    ignore_alpha: scene.ignore_alpha,
                    max_memory_bytes: max_memory,
                    ..Options::new(key.sun, Size::Resolution(resolution))
                };
                let done = |p: bake::Progress| tell(p.done_tiles as f64 / p.total_tiles.max(1) as f64);
                AnyFile::Light(bake_light(&scene.still, &options, key.layout, &done, cancel)?)
            }
            FileKind::Tree => {
                let options = TreeOptions {
                    ignore_alpha: scene.ignore_alpha,
                    max_memory_bytes: max_memory,
                    ..TreeOptions::new(key.sun, Size::Resolution(resolution))
                };
                let baked = bake_tree(&scene.still, &options, &|p| tell(p.done_share), cancel)?;
                AnyFile::Tree(TreeFile {
                    space: baked.space,
                    sun: key.sun,
                    settings: baked.settings,
                    regions: baked.regions,
                    body: TreeBody::Words(baked.tree),
                    attribute: Vec::new(),
                    attribute_kind: None,
                })
            }
        };
        teller.tell(News::Baked { bake, file, last: resolution == key.resolution });
    }
    Ok(())
}

fn bake_light(
    scene: &Scene,
    options: &Options,
    layout: Layout,
    progress: &(dyn Fn(bake::Progress) + Sync),
    cancel: &AtomicBool,
) -> adumbra::Result<ShadowFile> {
    if layout == Layout::Hierarchy {
        let baked = bake::bake_hierarchy(scene, options, true, progress, cancel)?;
        return Ok(ShadowFile::hierarchy(baked.grid, baked.settings, baked.hierarchy));
    }
    let baked = bake::bake(scene, options, progress, cancel)?;
    ShadowFile::of_dag(baked.grid, baked.settings, baked.dag, layout).map_err(Error::from)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;
    use std::sync::mpsc;

    use adumbra::scene::{GeneratedKind, generate};

    use super::*;
    use crate::settings::tests::settings;

    fn scene() -> Arc<LoadedScene> {
        let scene = generate(GeneratedKind::Primitives, 1);
        Arc::new(LoadedScene::new(PathBuf::from("primitives"), scene, false))
    }

    #[test]
    fn levels_go_from_coarse_to_what_was_asked_for() {
        assert_eq!(levels(8192), [512, 2048, 8192]);
        assert_eq!(levels(1024), [1024]);
        assert_eq!(levels(256), [256]);
    }

    #[test]
    fn hierarchy_serves_all_and_packed_no_penumbrae() {
        let hard = BakeKey::new(FileKind::Light, 1, &settings());
        let mut soft = settings();
        soft.shadows[0] = "voxel:soft".parse().unwrap();
        let soft = BakeKey::new(FileKind::Light, 1, &soft);
        assert_eq!((hard.layout, soft.layout), (Layout::Packed, Layout::Hierarchy));
        assert!(hard.serves(&hard) && soft.serves(&hard) && soft.serves(&soft) && !hard.serves(&soft));
        assert!(!soft.serves(&BakeKey { resolution: 512, ..hard }));
    }

    #[test]
    fn bake_tells_every_level_of_either_kind() {
        let sun = Sun::from_angles(40.0, 50.0).unwrap();
        for (kind, finest) in [(FileKind::Light, 2048), (FileKind::Tree, 512)] {
            let (tell, told) = mpsc::channel();
            let teller = Teller::new(move |news| tell.send(news).unwrap());
            let key = BakeKey::new(kind, 1, &Settings { sun, resolution: finest, ..settings() });
            let running = RunningBake::start(key, scene(), None, teller);
            let mut landed = Vec::new();
            for news in told {
                match news {
                    News::Baked { bake, file, last } => {
                        assert_eq!(bake, running.number);
                        let (is, resolution) = match file {
                            AnyFile::Light(file) => (FileKind::Light, file.settings.resolution),
                            AnyFile::Tree(file) => (FileKind::Tree, file.space.side_voxels()),
                        };
                        assert_eq!(is, kind);
                        landed.push((u64::from(resolution), last));
                    }
                    News::BakeEnded { error, .. } => panic!("{error:?}"),
                    _ => {}
                }
            }
            let expected = levels(finest).into_iter().map(|r| (r, r == finest));
            assert_eq!(landed, expected.collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_bake_that_panics_ends_with_a_message() {
        let mut broken = generate(GeneratedKind::Primitives, 1);
        broken.instances[0].mesh = u32::MAX;
        let path = PathBuf::from("broken");
        let (whole, still) = (Arc::new(broken.clone()), Arc::new(broken));
        let sound = LoadedScene::new(path, generate(GeneratedKind::Primitives, 1), false);
        let scene = Arc::new(LoadedScene { whole, still, ..sound });
        for kind in [FileKind::Light, FileKind::Tree] {
            let (tell, told) = mpsc::channel();
            let teller = Teller::new(move |news| tell.send(news).unwrap());
            let key = BakeKey::new(kind, 1, &settings());
            let running = RunningBake::start(key, scene.clone(), None, teller);
            let ended: Vec<_> = told.iter().collect();
            let [News::BakeEnded { bake, error: Some(error) }] = &ended[..] else {
                panic!("{}", ended.len())
            };
            assert!(*bake == running.number && error.contains("please report it"), "{error}");
        }
    }

    #[test]
    fn bake_that_is_cancelled_ends_without_an_error() {
        let sun = Sun::from_angles(40.0, 50.0).unwrap();
        let (tell, told) = mpsc::channel();
        let teller = Teller::new(move |news| tell.send(news).unwrap());
        let key = BakeKey::new(FileKind::Light, 1, &Settings { sun, resolution: 32_768, ..settings() });
        let running = RunningBake::start(key, scene(), None, teller);
        running.cancel();
        let ended: Vec<_> =
            told.iter().filter(|n| matches!(n, News::BakeEnded { error: None, .. })).collect();
        assert_eq!(ended.len(), 1);
    }
}
