//! Damaged, full and failing caches: bakes continue without them. Only entries and temporary files are
//! removed.

use std::fs::{self, File};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

use adumbra::{IoError, Sun};
use adumbra_bake::{
    Bake, BakeCache, BakeOptions, BakePlan, Baker, BestEffortCache, CacheKey, DiskCache, ENTRY_MAGIC, Error,
    Fetched, FrameChoice, MemoryCache, PartBaker, Report, Size, Watch,
};
use adumbra_scene::{GeneratedKind, Scene, generate};

fn options() -> BakeOptions {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    BakeOptions::new(sun, Size::Resolution(1024)).with(|o| o.frame = FrameChoice::ObliqueAt(0.0))
}

fn scene() -> Scene {
    generate(GeneratedKind::Primitives, 1)
}

fn fresh(scene: &Scene) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    Bake::with_options(scene, &options()).write_to(&mut out).unwrap();
    out.into_inner()
}

fn bake_with(scene: &Scene, cache: impl BakeCache + 'static) -> (Vec<u8>, Report) {
    let cache: Arc<dyn BakeCache> = Arc::new(cache);
    bake_from(scene, &cache)
}

fn bake_from(scene: &Scene, cache: &Arc<dyn BakeCache>) -> (Vec<u8>, Report) {
    let mut out = Cursor::new(Vec::new());
    let written = Bake::with_options(scene, &options()).cache(Arc::clone(cache)).write_to(&mut out).unwrap();
    (out.into_inner(), written.report)
}

/// All files below a folder that have the names of entries.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let list = |folder: PathBuf| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = list(folder.to_owned()).flat_map(list).collect();
    files.sort();
    files
}

#[test]
fn foreign_files_are_neither_counted_nor_removed() {
    let folder = tempfile::tempdir().unwrap();
    let (place, outside) = (folder.path().join("cache"), folder.path().join("outside"));
    let cache = DiskCache::create(&place).unwrap();
    let name = |c: &str| format!("{}.entry", c.repeat(62));
    let entry = [&ENTRY_MAGIC[..], b" and more"].concat();
    let write = |path: PathBuf, bytes: &[u8]| {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path
    };
    // A folder of pictures, given by mistake, has names like these.
    let mut others = vec![
        write(place.join("ab/notes.entry"), &entry),
        write(place.join("abc").join(name("a")), &entry),
        write(place.join("AB").join(name("a")), &entry),
        write(place.join("ab").join(name("A")), &entry),
        write(place.join("ab").join(name("a")).with_extension("png"), &entry),
        write(place.join("ab").join(format!("a{}", name("a"))), &entry),
        write(place.join(name("a")), &entry),
        write(place.join("ab").join(name("b")), b"mine, and not an entry"),
        write(place.join("ab").join(name("c")), b"ADUX"),
        write(outside.join(name("a")), &entry),
    ];
    fs::create_dir(place.join("ab").join(name("d"))).unwrap();
    others.push(place.join("ab").join(name("d")));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&outside, place.join("cd")).unwrap();
        std::os::unix::fs::symlink(outside.join(name("a")), place.join("ab").join(name("e"))).unwrap();
        others.extend([place.join("cd"), place.join("ab").join(name("e"))]);
        // Nothing is read from behind a link, or written there.
        let key: CacheKey = format!("cd{}", "a".repeat(62)).parse().unwrap();
        assert_eq!(cache.get(&key, 100).unwrap(), Fetched::Nothing);
        let other: CacheKey = format!("cd{}", "b".repeat(62)).parse().unwrap();
        assert!(cache.put(&other, &entry).unwrap_err().to_string().contains("link"));
        // Nor are temporary files there removed.
        std::os::unix::fs::symlink(&outside, place.join("new")).unwrap();
        let left = write(outside.join(".adumbra-a-abcdef.tmp"), b"left");
        let long_ago = SystemTime::now() - Duration::from_hours(48);
        File::options().append(true).open(&left).unwrap().set_modified(long_ago).unwrap();
        others.push(left);
    }
    // A power failure may leave files like the last three.
    let removable = [
        write(place.join("ab").join(name("f")), &entry),
        write(place.join("00").join(name("1")), b"ADUM"),
        write(place.join("00").join(name("2")), &[0; 90]),
        write(place.join("00").join(name("0")), b""),
    ];
    let found = cache.contents().unwrap();
    let bytes = entry.len() as u64 + 4 + 90;
    assert_eq!((found.entries, found.bytes, found.abandoned), (4, bytes, 0));
    let removed = cache.prune(0).unwrap();
    assert_eq!((removed.bytes, removed.abandoned), (bytes, 0));
    assert!(removed.failures.is_empty() && removable[..3].iter().all(|path| !path.exists()));
    for path in others {
        assert!(fs::symlink_metadata(&path).is_ok(), "{}", path.display());
    }
}

#[test]
fn abandoned_temporary_files_are_counted_and_removed_after_a_day() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("cache");
    let cache = DiskCache::create(&place).unwrap();
    cache.put(&"a".repeat(64).parse().unwrap(), ENTRY_MAGIC).unwrap();
    let leave = |name: &str, hours: u64| {
        let path = place.join("new").join(name);
        fs::write(&path, "half an entry").unwrap();
        let file = File::options().append(true).open(&path).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_hours(hours)).unwrap();
        (path, file)
    };
    let (old, _) = leave(".adumbra-a-abcdef.tmp", 25);
    // A bake on another machine may be writing this file, and its lock may not be visible here.
    let (young, _) = leave(".adumbra-a-abcdeg.tmp", 23);
    let (held, lock) = leave(".adumbra-a-abcdeh.tmp", 25);
    lock.lock().unwrap();
    let (foreign, _) = leave("notes.tmp", 25);
    let found = DiskCache::open(&place).unwrap().contents().unwrap();
    assert_eq!((found.entries, found.abandoned, found.abandoned_bytes), (1, 1, 13));
    assert!(old.exists(), "opening and counting must not remove files");
    let removed = cache.prune(1 << 20).unwrap();
    assert_eq!((removed.entries, removed.abandoned, removed.abandoned_bytes), (0, 1, 13));
    assert!(!old.exists() && young.exists() && held.exists() && foreign.exists());
    let (old, _) = leave(".adumbra-a-abcdef.tmp", 25);
    DiskCache::create(&place).unwrap();
    assert!(!old.exists() && young.exists() && held.exists() && foreign.exists());
}

/// Puts something in the place of an entry.
type Damage = fn(&Path);

#[cfg(unix)]
#[test]
fn entries_that_are_not_files_or_too_long_are_rebuilt() {
    let scene = scene();
    let bytes = fresh(&scene);
    let damages: [(&str, Damage, bool); 6] = [
        ("a folder", |path| fs::create_dir(path).unwrap(), false),
        ("a link to nothing", |path| std::os::unix::fs::symlink("nothing", path).unwrap(), true),
        ("a link to zeros", |path| std::os::unix::fs::symlink("/dev/zero", path).unwrap(), true),
        (
            "a pipe",
            |path| assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success()),
            true,
        ),
        ("a long file", |path| File::create(path).unwrap().set_len(3 << 30).unwrap(), true),
        ("an empty file", |path| drop(File::create(path).unwrap()), true),
    ];
    for (what, damage, is_replaced) in damages {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::create(folder.path()).unwrap();
        bake_with(&scene, cache.clone());
        let damaged = entries(folder.path()).swap_remove(0);
        let whole = fs::read(&damaged).unwrap();
        fs::remove_file(&damaged).unwrap();
        damage(&damaged);
        let failures = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&failures);
        let cached = BestEffortCache::new(cache, move |error: &IoError| {
            assert!(error.to_string().contains(".entry"), "{error}");
            counted.fetch_add(1, Ordering::Relaxed);
        });
        let (again, report) = bake_with(&scene, cached);
        assert!(again == bytes && report.reused_root_blocks < report.root_blocks, "{what}");
        assert_eq!(failures.load(Ordering::Relaxed), usize::from(!is_replaced), "{what}");
        assert_eq!(fs::symlink_metadata(&damaged).unwrap().is_file(), is_replaced, "{what}");
        assert!(!is_replaced || fs::read(&damaged).unwrap() == whole, "{what}");
    }
}

/// A cache that fails, and counts its calls.
#[derive(Debug, Default)]
struct Failing {
    inner: MemoryCache,
    reads: bool,
    writes: bool,
    asked: AtomicU64,
}

impl Failing {
    fn fail(&self) -> IoError {
        self.asked.fetch_add(1, Ordering::Relaxed);
        IoError::at("reach", "the cache")(std::io::ErrorKind::ReadOnlyFilesystem.into())
    }
}

impl BakeCache for Failing {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        if self.reads { self.inner.get(key, most_bytes) } else { Err(self.fail()) }
    }

    fn put(&self, _: &CacheKey, _: &[u8]) -> Result<(), IoError> {
        if self.writes { Ok(()) } else { Err(self.fail()) }
    }
}

#[test]
fn failing_cache_is_reported_once_and_soon_abandoned() {
    let scene = generate(GeneratedKind::City, 3);
    let bytes = fresh(&scene);
    for reads in [false, true] {
        let failing = Arc::new(Failing { reads, ..Failing::default() });
        let said = Arc::new(Mutex::new(Vec::new()));
        let (cache, says): (Arc<dyn BakeCache>, _) = (failing.clone(), Arc::clone(&said));
        let cached =
            BestEffortCache::new(cache, move |error: &IoError| says.lock().unwrap().push(error.to_string()));
        let (found, report) = bake_with(&scene, cached);
        assert!(found == bytes && report.reused_root_blocks == 0);
        let said = said.lock().unwrap();
        assert!(matches!(&said[..], [one] if one.contains("the cache")), "{said:?}");
        // Three reads and three writes, and the calls that other threads had begun.
        let asked = failing.asked.load(Ordering::Relaxed);
        assert!(asked <= 2 * (3 + rayon::current_num_threads() as u64), "{asked}");
    }
}

#[test]
fn a_baker_links_although_its_cache_fails() {
    let scene = scene();
    for writes in [false, true] {
        let failing = Failing { writes, ..Failing::default() };
        let cached = BestEffortCache::new(failing, |_| {}).with_memory();
        let mut baker = Baker::with_cache(scene.clone(), &options(), cached).unwrap();
        let mut out = Cursor::new(Vec::new());
        // Bake again the entries that the cache took but cannot return, until it is no longer used.
        while let Err(error) =
            baker.bake(None, Watch::none()).and_then(|_| baker.write_to(&mut out, Watch::none()))
        {
            assert!(writes && matches!(error, Error::MissingParts { .. }), "{error}");
            baker.forget();
            out = Cursor::new(Vec::new());
        }
        assert!(out.into_inner() == fresh(&scene), "{writes}");
    }
}

/// A cache that notes the largest limit of its reads and the longest entry that it returned.
#[derive(Debug, Default)]
struct Noting(MemoryCache, Mutex<[u64; 2]>);

impl BakeCache for Noting {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        let found = self.0.get(key, most_bytes)?;
        let mut noted = self.1.lock().unwrap();
        noted[0] = noted[0].max(most_bytes);
        if let Fetched::Whole(bytes) = &found {
            noted[1] = noted[1].max(bytes.len() as u64);
        }
        Ok(found)
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        self.0.put(key, bytes)
    }
}

#[test]
fn reads_are_limited_to_the_size_of_a_part_and_the_memory_limit() {
    let (scene, noting) = (scene(), Arc::new(Noting::default()));
    let cache: Arc<dyn BakeCache> = noting.clone();
    let (bytes, _) = bake_from(&scene, &cache);
    // A page at 1024 texels, at most.
    let unlimited = noting.1.lock().unwrap()[0];
    assert!((1 << 20..4 << 20).contains(&unlimited), "{unlimited}");
    let limit = 4 << 20;
    let limited = options().with(|o| o.max_memory_bytes = Some(limit));
    *noting.1.lock().unwrap() = [0; 2];
    let mut out = Cursor::new(Vec::new());
    let written = Bake::with_options(&scene, &limited).cache(Arc::clone(&cache)).write_to(&mut out).unwrap();
    assert!(out.into_inner() == bytes && written.report.reused_root_blocks == written.report.root_blocks);
    let [asked, given] = *noting.1.lock().unwrap();
    assert!(asked <= limit / 8 && (1..limit / 8).contains(&given), "{asked} {given}");
}

#[test]
fn linking_reports_a_part_beyond_the_memory_limit() {
    let (scene, options) = (scene(), options());
    let cache: Arc<dyn BakeCache> = Arc::new(MemoryCache::default());
    let plan = BakePlan::new(&scene, &options).unwrap();
    let ids: Vec<usize> = (0..plan.parts().len()).collect();
    PartBaker::new(&scene, &plan, &options).unwrap().bake(&ids, &cache, Watch::none()).unwrap();
    let limited = |bytes| options.clone().with(|o| o.max_memory_bytes = Some(bytes));
    let mut out = Cursor::new(Vec::new());
    plan.link(&cache, &limited(64 << 20), Watch::none(), &mut out).unwrap();
    assert!(out.into_inner() == fresh(&scene));
    let refused = |bytes| match plan.link(&cache, &limited(bytes), Watch::none(), Cursor::new(Vec::new())) {
        Err(Error::MemoryLimit { what, needed_bytes, .. }) => (what, needed_bytes),
        other => panic!("{other:?}"),
    };
    let (what, needed_bytes) = refused(10_000);
    assert!(what == "reading a part" && needed_bytes > 10_000, "{what}: {needed_bytes}");
    // With that much memory, the next step does not fit.
    assert_eq!(refused(needed_bytes).0, "linking the pages");
}
