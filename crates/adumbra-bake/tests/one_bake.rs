//! [`Bake`]: every way to run it gives the same file, and one that fails leaves the file that was there.

use std::fs;
use std::io::Cursor;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use adumbra::{Encoding, IoError, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeCache, BakeOptions, CacheKey, Error, Fetched, MemoryCache, Size};
use adumbra_scene::{GeneratedKind, Scene, generate};

fn scene() -> Scene {
    generate(GeneratedKind::Primitives, 1)
}

fn sun() -> Sun {
    Sun::from_direction([0.5, 0.8, 0.35]).unwrap()
}

fn bytes(bake: &Bake<'_>) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    bake.write_to(&mut out).unwrap();
    out.into_inner()
}

#[test]
fn saved_written_and_in_memory_files_are_the_same() {
    let (scene, folder) = (scene(), tempfile::tempdir().unwrap());
    let path = folder.path().join("p.adumbra");
    let bake = Bake::new(&scene, sun()).resolution(1024);
    let summary = bake.save(&path).unwrap();
    let saved = fs::read(&path).unwrap();
    assert_eq!(summary.bytes, saved.len() as u64);
    assert!(saved == bytes(&bake));
    let in_memory = bake.in_memory().unwrap();
    assert!(in_memory.to_bytes(Encoding::default()).unwrap() == saved);
    assert!(ShadowFile::from_bytes(&saved).unwrap() == in_memory);
    assert_eq!((summary.grid, summary.settings), (in_memory.grid, in_memory.settings));
    assert_eq!(summary.levels, in_memory.level_count());
}

#[test]
fn setters_change_the_options() {
    let scene = scene();
    let options = BakeOptions::new(sun(), Size::VoxelSize(0.05)).with(|o| {
        o.thickness_world = 0.1;
        o.levels = 1;
    });
    let set = Bake::new(&scene, sun()).voxel_size(0.05).with(|options| {
        options.thickness_world = 0.1;
        options.levels = 1;
    });
    assert!(bytes(&set) == bytes(&Bake::with_options(&scene, &options)));
    let bytes_at = |texels| Bake::new(&scene, sun()).resolution(texels).estimate().unwrap().file_bytes;
    let default = Bake::new(&scene, sun()).estimate().unwrap().file_bytes;
    assert!(default == bytes_at(8192) && default != bytes_at(4096), "{default:?}");
}

#[test]
fn interrupted_save_keeps_the_old_file() {
    let (scene, folder) = (scene(), tempfile::tempdir().unwrap());
    let path = folder.path().join("p.adumbra");
    fs::write(&path, "the old file").unwrap();
    let cancel = AtomicBool::new(false);
    let bake = Bake::new(&scene, sun())
        .resolution(1024)
        .on_progress(|_| cancel.store(true, Ordering::Relaxed))
        .cancel(&cancel);
    assert!(matches!(bake.save(&path), Err(Error::Interrupted)));
    assert_eq!(fs::read_to_string(&path).unwrap(), "the old file");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "a temporary file is left");
}

#[test]
fn save_to_a_missing_folder_names_the_folder() {
    let (scene, folder) = (scene(), tempfile::tempdir().unwrap());
    let error =
        Bake::new(&scene, sun()).resolution(64).save(folder.path().join("none/p.adumbra")).unwrap_err();
    assert!(matches!(&error, Error::Io(_)) && error.to_string().contains("none"), "{error}");
}

/// With or without a limit, a bake builds nothing that the cache has.
#[test]
fn cached_bake_builds_nothing_with_and_without_a_switch_limit() {
    let scene = scene();
    for switch_within_voxels in [0, 4] {
        let cache = Arc::new(MemoryCache::default());
        let reports = [(); 2].map(|()| {
            let bake = Bake::new(&scene, sun())
                .resolution(512)
                .with(|options| options.switch_within_voxels = switch_within_voxels)
                .cache(Arc::clone(&cache));
            bake.in_memory_with_report().unwrap()
        });
        let [(first, built), (second, reused)] = reports;
        assert!(first == second && built.drawn_texels > 0 && built.reused_root_blocks == 0);
        assert_eq!(reused.reused_root_blocks, reused.root_blocks);
        assert_eq!(reused.drawn_texels, 0, "{switch_within_voxels}");
    }
}

/// A cache that cannot be written.
#[derive(Debug)]
struct Full;

impl BakeCache for Full {
    fn get(&self, _: &CacheKey, _: u64) -> Result<Fetched, IoError> {
        Ok(Fetched::Nothing)
    }

    fn put(&self, _: &CacheKey, _: &[u8]) -> Result<(), IoError> {
        Err(IoError::at("write", "the cache")(std::io::ErrorKind::StorageFull.into()))
    }
}

#[test]
fn failing_cache_ends_the_bake_and_keeps_the_old_file() {
    let (scene, folder) = (scene(), tempfile::tempdir().unwrap());
    let path = folder.path().join("p.adumbra");
    fs::write(&path, "the old file").unwrap();
    let error = Bake::new(&scene, sun()).resolution(512).cache(Full).save(&path).unwrap_err();
    assert!(matches!(&error, Error::Io(e) if e.path.ends_with("the cache")), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "the old file");
}

#[test]
fn estimate_can_be_cancelled() {
    let scene = scene();
    let bake = Bake::new(&scene, sun()).resolution(512);
    assert!(bake.estimate().is_ok());
    let cancel = AtomicBool::new(true);
    assert!(matches!(bake.cancel(&cancel).estimate(), Err(Error::Interrupted)));
}

#[test]
fn progress_reaches_its_total() {
    let scene = scene();
    let (last, calls) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let bake = Bake::new(&scene, sun()).resolution(512).on_progress(|progress| {
        calls.fetch_add(1, Ordering::Relaxed);
        last.fetch_max(progress.done, Ordering::Relaxed);
        assert!(progress.done <= progress.total);
    });
    let (_, report) = bake.in_memory_with_report().unwrap();
    assert_eq!(last.load(Ordering::Relaxed), report.root_blocks);
    assert_eq!(calls.load(Ordering::Relaxed), report.root_blocks);
}
