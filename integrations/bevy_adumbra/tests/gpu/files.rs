//! Files that are loaded, replaced, damaged and dropped, and several at once.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use adumbra::{Bounds, Encoding, Filter, FormatError, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::{GeneratedKind, generate};
use adumbra_testing::full;
use async_channel::Sender;
use bevy::asset::io::memory::{Dir, MemoryAssetReader};
use bevy::asset::io::{AssetSourceBuilder, AssetSourceEvent, AssetSourceId, AssetWatcher};
use bevy::asset::{AssetLoadError, AssetPlugin, LoadState};
use bevy::prelude::*;
use bevy_adumbra::prelude::*;
use bevy_adumbra::{DeviceLimits, ShadowFileError};

use crate::stage::{Stage, assert_alike, baked, expected, towards_sun};

fn bytes(file: &ShadowFile) -> Vec<u8> {
    file.to_bytes(Encoding::default()).unwrap()
}

#[test]
fn two_tiles_make_one_world() {
    let scene = generate(GeneratedKind::City, 1);
    let sun = Sun::from_direction(towards_sun()).unwrap();
    // Parts of a world share their voxels if they share the frame.
    let frame = FrameChoice::ObliqueAt(0.0);
    let whole = baked(frame);
    let all = scene.bounds();
    let tile = |low: f64, high: f64| {
        let mut bounds = Bounds { min: all.min, max: all.max };
        (bounds.min[0], bounds.max[0]) = (low, high);
        let options = BakeOptions::new(sun, Size::VoxelSize(whole.grid.voxel_size)).with(|o| {
            o.bounds = Some(bounds);
            o.frame = frame;
        });
        Bake::with_options(&scene, &options).in_memory().unwrap()
    };
    let middle = 0.5 * (all.min[0] + all.max[0]);
    let mut stage = Stage::new(|_| {});
    stage.give(tile(all.min[0], middle + 2.0), |_| {});
    let second = BakedShadowFile::new(tile(middle - 2.0, all.max[0]), DeviceLimits::default()).unwrap();
    let second = stage.app.world_mut().resource_mut::<Assets<BakedShadowFile>>().add(second);
    stage.app.world_mut().get_mut::<BakedShadow>(stage.light).unwrap().files.push(second);
    let found = stage.visibility();
    assert_eq!(stage.status(), BakedShadowStatus::Active { files: 2 });
    // The tiles have the voxels of the whole file, except in columns that may switch anywhere.
    let off = found.iter().zip(expected(&whole, Filter::Box5)).filter(|(a, b)| (*a - b).abs() > 0.25).count();
    assert!(off * 500 <= found.len(), "{off} of {}", found.len());
}

/// An asset source in memory. The test sends the change events of its watcher.
#[derive(Clone)]
struct MemorySource {
    folder: Dir,
    events: Arc<Mutex<Option<Sender<AssetSourceEvent>>>>,
}

/// A watcher that does nothing: the test sends the events.
struct NoWatcher;

impl AssetWatcher for NoWatcher {}

impl MemorySource {
    fn new() -> Self {
        Self { folder: Dir::default(), events: Arc::default() }
    }

    fn register(&self, app: &mut App) {
        let (folder, events) = (self.folder.clone(), Arc::clone(&self.events));
        let source = AssetSourceBuilder::new(move || Box::new(MemoryAssetReader { root: folder.clone() }))
            .with_watcher(move |sender| {
                *events.lock().unwrap() = Some(sender);
                Some(Box::new(NoWatcher))
            });
        app.register_asset_source(AssetSourceId::Default, source);
    }

    fn write(&self, name: &str, bytes: Vec<u8>) {
        self.folder.insert_asset(Path::new(name), bytes);
        if let Some(events) = &*self.events.lock().unwrap() {
            events.try_send(AssetSourceEvent::ModifiedAsset(name.into())).unwrap();
        }
    }
}

#[test]
fn reloads_a_replaced_file_but_not_a_damaged_one() {
    let source = MemorySource::new();
    let (light, oblique) = (baked(FrameChoice::Light), baked(FrameChoice::Oblique));
    source.write("city.adumbra", bytes(&light));
    let mut stage = Stage::with_plugin(watching(AssetPlugin::default()), |app| source.register(app));
    replaced_and_damaged(&mut stage, [&light, &oblique], |bytes| source.write("city.adumbra", bytes));
}

#[test]
#[ignore = "slow: waits until the system's watcher has seen a file change"]
fn reloads_a_file_replaced_on_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.adumbra");
    let (light, oblique) = (baked(FrameChoice::Light), baked(FrameChoice::Oblique));
    fs::write(&path, bytes(&light)).unwrap();
    let mut stage = Stage::with_assets(&folder.path().to_string_lossy());
    replaced_and_damaged(&mut stage, [&light, &oblique], |bytes| {
        // Replace the file as `adumbra bake` does, so slowly that the watcher does not take it for a new
        // file.
        let write = |file: &mut fs::File| {
            std::thread::sleep(Duration::from_millis(700));
            file.write_all(&bytes).map(|()| bytes.len() as u64)
        };
        adumbra_files::replace_file(&path, write).unwrap();
    });
}

/// Draws the first file, then the second file, which replaces it, and the second file again after a damaged
/// file has replaced it in the asset source.
fn replaced_and_damaged(stage: &mut Stage, [first, second]: [&ShadowFile; 2], replace: impl Fn(Vec<u8>)) {
    let handle = stage.app.world().resource::<AssetServer>().load("city.adumbra");
    stage.app.world_mut().entity_mut(stage.light).insert(BakedShadow::new(handle.clone()));
    stage.wait_for(|stage| stage.status().is_active());
    assert_alike(&stage.visibility(), &expected(first, Filter::Box5), Filter::Box5);
    let frame = |stage: &Stage| {
        let files = stage.app.world().resource::<Assets<BakedShadowFile>>();
        files.get(&handle).map(|file| file.grid().frame)
    };
    replace(bytes(second));
    stage.wait_for(|stage| frame(stage) == Some(second.grid.frame));
    assert_alike(&stage.visibility(), &expected(second, Filter::Box5), Filter::Box5);
    let mut damaged = bytes(first);
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    replace(damaged);
    let state = |stage: &Stage| stage.app.world().resource::<AssetServer>().get_load_state(&handle);
    stage.wait_for(|stage| matches!(state(stage), Some(LoadState::Failed(_))));
    let Some(LoadState::Failed(error)) = state(stage) else { unreachable!("it failed") };
    assert!(error.to_string().contains("checksum"), "{error}");
    assert_alike(&stage.visibility(), &expected(second, Filter::Box5), Filter::Box5);
    assert!(stage.status().is_active());
}

/// Reloads assets that change.
fn watching(assets: AssetPlugin) -> AssetPlugin {
    AssetPlugin { watch_for_changes_override: Some(true), ..assets }
}

#[test]
fn reports_a_file_that_is_not_a_shadow_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bad.adumbra"), b"not a shadow file").unwrap();
    let mut stage = Stage::with_assets(&folder.path().to_string_lossy());
    let handle = stage.app.world().resource::<AssetServer>().load("bad.adumbra");
    stage.app.world_mut().entity_mut(stage.light).insert(BakedShadow::new(handle));
    stage.wait_for(|stage| matches!(stage.status(), BakedShadowStatus::Unusable(_)));
    let BakedShadowStatus::Unusable(BakedShadowError::NotLoaded(error)) = stage.status() else {
        panic!("{:?}", stage.status());
    };
    let AssetLoadError::AssetLoaderError(error) = &*error else { panic!("{error:?}") };
    let error = error.error().downcast_ref();
    assert!(matches!(error, Some(ShadowFileError::Invalid(FormatError::Magic { .. }))), "{error:?}");
    assert!(stage.visibility().iter().all(|v| (v - 1.0).abs() < 0.01));
}

#[test]
fn many_files_leave_no_texture_behind() {
    let file = baked(FrameChoice::Oblique);
    let mut stage = Stage::new(|_| {});
    // Textures are made whether a camera draws or not.
    stage.app.world_mut().get_mut::<Camera>(stage.camera).unwrap().is_active = false;
    let bytes = |stage: &Stage| {
        let device = stage.app.world().resource::<bevy::render::renderer::RenderDevice>();
        let report = device.wgpu_device().generate_allocator_report();
        report.map_or(0, |report| report.total_allocated_bytes)
    };
    let one = |stage: &mut Stage| {
        stage.give(file.clone(), |_| {});
        stage.update();
        stage.app.world_mut().entity_mut(stage.light).remove::<BakedShadow>();
        stage.update();
    };
    for _ in 0..20 {
        one(&mut stage);
    }
    let before = bytes(&stage);
    for _ in 0..if full() { 1000 } else { 200 } {
        one(&mut stage);
    }
    let after = bytes(&stage);
    println!("{before} bytes of the device's memory before, {after} after");
    assert!(after <= before + (1 << 20), "{before} {after}");
    assert_eq!(stage.app.world().resource::<Assets<BakedShadowFile>>().len(), 0);
}

impl Stage {
    pub fn with_assets(folder: &str) -> Self {
        let assets = AssetPlugin { file_path: folder.to_owned(), ..default() };
        Self::with_plugin(watching(assets), |_| {})
    }

    /// Updates the app until a condition holds. It fails only after minutes, because a busy machine is slow.
    pub fn wait_for(&mut self, done: impl Fn(&Self) -> bool) {
        let start = Instant::now();
        while !done(self) {
            assert!(start.elapsed() < Duration::from_secs(300), "waited too long: {:?}", self.status());
            self.update();
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}
