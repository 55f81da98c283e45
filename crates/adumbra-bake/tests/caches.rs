//! Caches that are damaged, full or not what they seem: bakes go on without them, and nothing that is not an object is
//! removed.

use std::fs::{self, File};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

use adumbra::{IoError, Sun};
use adumbra_bake::{
    BakeOptions, BakePlan, Baker, CachedObjects, Error, Fetched, FolderObjects, FrameChoice, MemoryObjects,
    OBJECT_MAGIC, ObjectKey, Objects, PartBaker, Report, Size, Watch, bake_to, bake_with_objects, link,
};
use adumbra_scene::{GeneratedKind, Scene, generate};

fn options() -> BakeOptions {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    BakeOptions { frame: FrameChoice::ObliqueAt(0.0), ..BakeOptions::new(sun, Size::Resolution(1024)) }
}

fn scene() -> Scene {
    generate(GeneratedKind::Primitives, 1)
}

fn fresh(scene: &Scene) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    bake_to(scene, &options(), Watch::none(), &mut out).unwrap();
    out.into_inner()
}

fn bake_with(scene: &Scene, objects: impl Objects + 'static) -> (Vec<u8>, Report) {
    let objects: Arc<dyn Objects> = Arc::new(objects);
    bake_from(scene, &objects)
}

fn bake_from(scene: &Scene, objects: &Arc<dyn Objects>) -> (Vec<u8>, Report) {
    let mut out = Cursor::new(Vec::new());
    let written = bake_with_objects(scene, &options(), objects, Watch::none(), &mut out).unwrap();
    (out.into_inner(), written.report)
}

/// All files below a folder that have the names of objects.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let list = |folder: PathBuf| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = list(folder.to_owned()).flat_map(list).collect();
    files.sort();
    files
}

#[test]
fn what_is_no_object_is_neither_counted_nor_removed() {
    let folder = tempfile::tempdir().unwrap();
    let (cache, outside) = (folder.path().join("cache"), folder.path().join("outside"));
    let objects = FolderObjects::create(&cache).unwrap();
    let name = |c: &str| format!("{}.object", c.repeat(62));
    let object = [&OBJECT_MAGIC[..], b" and more"].concat();
    let write = |path: PathBuf, bytes: &[u8]| {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, bytes).unwrap();
        path
    };
    // A folder of pictures, given by mistake, has names like these.
    let mut others = vec![
        write(cache.join("ab/notes.object"), &object),
        write(cache.join("abc").join(name("a")), &object),
        write(cache.join("AB").join(name("a")), &object),
        write(cache.join("ab").join(name("A")), &object),
        write(cache.join("ab").join(name("a")).with_extension("png"), &object),
        write(cache.join("ab").join(format!("a{}", name("a"))), &object),
        write(cache.join(name("a")), &object),
        write(cache.join("ab").join(name("b")), b"mine, and not an object"),
        write(cache.join("ab").join(name("c")), b"ADUX"),
        write(outside.join(name("a")), &object),
    ];
    fs::create_dir(cache.join("ab").join(name("d"))).unwrap();
    others.push(cache.join("ab").join(name("d")));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&outside, cache.join("cd")).unwrap();
        std::os::unix::fs::symlink(outside.join(name("a")), cache.join("ab").join(name("e"))).unwrap();
        others.extend([cache.join("cd"), cache.join("ab").join(name("e"))]);
        // Nothing is read from behind a link, or written there.
        let key: ObjectKey = format!("cd{}", "a".repeat(62)).parse().unwrap();
        assert_eq!(objects.get(&key, 100).unwrap(), Fetched::Nothing);
        let other: ObjectKey = format!("cd{}", "b".repeat(62)).parse().unwrap();
        assert!(objects.put(&other, &object).unwrap_err().to_string().contains("link"));
        // Nor are temporary files there removed.
        std::os::unix::fs::symlink(&outside, cache.join("new")).unwrap();
        let left = write(outside.join(".adumbra-a-abcdef.tmp"), b"left");
        let long_ago = SystemTime::now() - Duration::from_hours(48);
        File::options().append(true).open(&left).unwrap().set_modified(long_ago).unwrap();
        others.push(left);
    }
    // The last three are what a power failure may leave.
    let removable = [
        write(cache.join("ab").join(name("f")), &object),
        write(cache.join("00").join(name("1")), b"ADUM"),
        write(cache.join("00").join(name("2")), &[0; 90]),
        write(cache.join("00").join(name("0")), b""),
    ];
    let found = objects.contents().unwrap().contents;
    let bytes = object.len() as u64 + 4 + 90;
    assert_eq!((found.objects, found.bytes, found.abandoned), (4, bytes, 0));
    let removed = objects.prune(0).unwrap();
    assert_eq!((removed.contents.bytes, removed.contents.abandoned), (bytes, 0));
    assert!(removed.failures.is_empty() && removable[..3].iter().all(|path| !path.exists()));
    for path in others {
        assert!(fs::symlink_metadata(&path).is_ok(), "{}", path.display());
    }
}

#[test]
fn files_that_killed_programs_left_in_a_cache_are_counted_and_removed_after_a_day() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let objects = FolderObjects::create(&cache).unwrap();
    objects.put(&"a".repeat(64).parse().unwrap(), OBJECT_MAGIC).unwrap();
    let leave = |name: &str, hours: u64| {
        let path = cache.join("new").join(name);
        fs::write(&path, "half an object").unwrap();
        let file = File::options().append(true).open(&path).unwrap();
        file.set_modified(SystemTime::now() - Duration::from_hours(hours)).unwrap();
        (path, file)
    };
    let (old, _) = leave(".adumbra-a-abcdef.tmp", 25);
    // A bake on another machine may write it just now, and its lock may not be seen here.
    let (young, _) = leave(".adumbra-a-abcdeg.tmp", 23);
    let (held, lock) = leave(".adumbra-a-abcdeh.tmp", 25);
    lock.lock().unwrap();
    let (foreign, _) = leave("notes.tmp", 25);
    let found = FolderObjects::open(&cache).unwrap().contents().unwrap().contents;
    assert_eq!((found.objects, found.abandoned, found.abandoned_bytes), (1, 1, 14));
    assert!(old.exists(), "who looks removes nothing");
    let removed = objects.prune(1 << 20).unwrap().contents;
    assert_eq!((removed.objects, removed.abandoned, removed.abandoned_bytes), (0, 1, 14));
    assert!(!old.exists() && young.exists() && held.exists() && foreign.exists());
    let (old, _) = leave(".adumbra-a-abcdef.tmp", 25);
    FolderObjects::create(&cache).unwrap();
    assert!(!old.exists() && young.exists() && held.exists() && foreign.exists());
}

/// Puts something in the place of an object.
type Damage = fn(&Path);

#[cfg(unix)]
#[test]
fn entries_that_are_no_files_or_too_long_are_made_again() {
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
        let objects = FolderObjects::create(folder.path()).unwrap();
        bake_with(&scene, objects.clone());
        let damaged = entries(folder.path()).swap_remove(0);
        let whole = fs::read(&damaged).unwrap();
        fs::remove_file(&damaged).unwrap();
        damage(&damaged);
        let failures = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&failures);
        let cached = CachedObjects::new(Arc::new(objects), move |error: &IoError| {
            assert!(error.to_string().contains(".object"), "{error}");
            counted.fetch_add(1, Ordering::Relaxed);
        });
        let (again, report) = bake_with(&scene, cached);
        assert!(again == bytes && report.reused_tiles < report.tiles, "{what}");
        assert_eq!(failures.load(Ordering::Relaxed), usize::from(!is_replaced), "{what}");
        assert_eq!(fs::symlink_metadata(&damaged).unwrap().is_file(), is_replaced, "{what}");
        assert!(!is_replaced || fs::read(&damaged).unwrap() == whole, "{what}");
    }
}

/// Objects that fail, and count how often they are asked.
#[derive(Debug, Default)]
struct Failing {
    inner: MemoryObjects,
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

impl Objects for Failing {
    fn get(&self, key: &ObjectKey, most_bytes: u64) -> Result<Fetched, IoError> {
        if self.reads { self.inner.get(key, most_bytes) } else { Err(self.fail()) }
    }

    fn put(&self, _: &ObjectKey, _: &[u8]) -> Result<(), IoError> {
        if self.writes { Ok(()) } else { Err(self.fail()) }
    }
}

#[test]
fn a_cache_that_fails_is_said_once_and_soon_left_alone() {
    let scene = generate(GeneratedKind::City, 3);
    let bytes = fresh(&scene);
    for reads in [false, true] {
        let failing = Arc::new(Failing { reads, ..Failing::default() });
        let said = Arc::new(Mutex::new(Vec::new()));
        let (objects, says): (Arc<dyn Objects>, _) = (failing.clone(), Arc::clone(&said));
        let cached =
            CachedObjects::new(objects, move |error: &IoError| says.lock().unwrap().push(error.to_string()));
        let (found, report) = bake_with(&scene, cached);
        assert!(found == bytes && report.reused_tiles == 0);
        let said = said.lock().unwrap();
        assert!(matches!(&said[..], [one] if one.contains("the cache")), "{said:?}");
        // Three of a kind, and those that other threads had begun.
        let asked = failing.asked.load(Ordering::Relaxed);
        assert!(asked <= 2 * (3 + rayon::current_num_threads() as u64), "{asked}");
    }
}

#[test]
fn a_baker_links_what_a_failing_cache_did_not_take() {
    let scene = scene();
    for writes in [false, true] {
        let failing = Failing { writes, ..Failing::default() };
        let cached = CachedObjects::new(Arc::new(failing), |_| {}).with_memory();
        let mut baker = Baker::with_objects(scene.clone(), &options(), Arc::new(cached)).unwrap();
        let mut out = Cursor::new(Vec::new());
        // What was taken, and cannot be read again, is baked again until nothing is asked of the cache.
        while let Err(error) =
            baker.bake(None, Watch::none()).and_then(|_| baker.write_to(Watch::none(), &mut out))
        {
            assert!(writes && matches!(error, Error::MissingParts { .. }), "{error}");
            baker.forget();
            out = Cursor::new(Vec::new());
        }
        assert!(out.into_inner() == fresh(&scene), "{writes}");
    }
}

/// Objects that note the most bytes that they were asked for, and the longest that they gave.
#[derive(Debug, Default)]
struct Noting(MemoryObjects, Mutex<[u64; 2]>);

impl Objects for Noting {
    fn get(&self, key: &ObjectKey, most_bytes: u64) -> Result<Fetched, IoError> {
        let found = self.0.get(key, most_bytes)?;
        let mut noted = self.1.lock().unwrap();
        noted[0] = noted[0].max(most_bytes);
        if let Fetched::Whole(bytes) = &found {
            noted[1] = noted[1].max(bytes.len() as u64);
        }
        Ok(found)
    }

    fn put(&self, key: &ObjectKey, bytes: &[u8]) -> Result<(), IoError> {
        self.0.put(key, bytes)
    }
}

#[test]
fn objects_are_read_up_to_what_a_part_and_the_memory_limit_allow() {
    let (scene, noting) = (scene(), Arc::new(Noting::default()));
    let objects: Arc<dyn Objects> = noting.clone();
    let (bytes, _) = bake_from(&scene, &objects);
    // A page at 1024 texels, at most.
    let unlimited = noting.1.lock().unwrap()[0];
    assert!((1 << 20..4 << 20).contains(&unlimited), "{unlimited}");
    let limit = 4 << 20;
    let limited = BakeOptions { max_memory_bytes: Some(limit), ..options() };
    *noting.1.lock().unwrap() = [0; 2];
    let mut out = Cursor::new(Vec::new());
    let written = bake_with_objects(&scene, &limited, &objects, Watch::none(), &mut out).unwrap();
    assert!(out.into_inner() == bytes && written.report.reused_tiles == written.report.tiles);
    let [asked, given] = *noting.1.lock().unwrap();
    assert!(asked <= limit / 8 && (1..limit / 8).contains(&given), "{asked} {given}");
}

#[test]
fn linking_says_that_a_part_does_not_fit_the_memory_limit() {
    let (scene, options) = (scene(), options());
    let objects: Arc<dyn Objects> = Arc::new(MemoryObjects::default());
    let plan = BakePlan::new(&scene, &options).unwrap();
    let ids: Vec<usize> = (0..plan.parts().len()).collect();
    PartBaker::new(&scene, &plan, &options).unwrap().bake(&ids, &objects, Watch::none()).unwrap();
    let limited = |bytes| BakeOptions { max_memory_bytes: Some(bytes), ..options.clone() };
    let mut out = Cursor::new(Vec::new());
    link(&plan, &objects, &limited(64 << 20), Watch::none(), &mut out).unwrap();
    assert!(out.into_inner() == fresh(&scene));
    let refused = |bytes| match link(&plan, &objects, &limited(bytes), Watch::none(), Cursor::new(Vec::new()))
    {
        Err(Error::MemoryLimit { what, needed_bytes, .. }) => (what, needed_bytes),
        other => panic!("{other:?}"),
    };
    let (what, needed_bytes) = refused(10_000);
    assert!(what == "reading a part" && needed_bytes > 10_000, "{what}: {needed_bytes}");
    // With so much, something else does not fit.
    assert_eq!(refused(needed_bytes).0, "linking the pages");
}
