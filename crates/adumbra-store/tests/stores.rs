//! Entries in stores. The test with an S3 server is in `python/tests`, because the server is a Python
//! package.

use std::io::Cursor;
use std::sync::Arc;
use std::thread;

use adumbra::Sun;
use adumbra_bake::{Bake, BakeCache, BakeOptions, CacheKey, ENTRY_MAGIC, Fetched, Size};
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_store::StoreCache;
use object_store::ObjectStoreExt;
use object_store::memory::InMemory;
use object_store::path::Path;

fn key(digit: char) -> CacheKey {
    digit.to_string().repeat(64).parse().expect("64 digits")
}

fn in_memory() -> StoreCache {
    StoreCache::new("memory".to_owned(), Arc::new(InMemory::new()), Path::from("below/here")).unwrap()
}

#[test]
fn stores_entries_and_replaces_damaged_ones() {
    let store = in_memory();
    assert_eq!(store.get(&key('a'), 5).unwrap(), Fetched::Nothing);
    store.put(&key('a'), b"first").unwrap();
    store.put(&key('a'), b"first").unwrap();
    assert_eq!(store.get(&key('a'), 5).unwrap(), Fetched::Whole(b"first".to_vec()));
    // A caller puts other bytes after it found the entry damaged.
    store.put(&key('a'), b"whole").unwrap();
    assert_eq!(store.get(&key('a'), 5).unwrap(), Fetched::Whole(b"whole".to_vec()));
    assert_eq!(store.get(&key('a'), 4).unwrap(), Fetched::TooLong(5));
    let all = store.contents().unwrap();
    assert_eq!((all.entries, all.bytes), (1, 5));
}

#[test]
fn concurrent_writers_of_one_entry_succeed() {
    let store = in_memory();
    let bytes = vec![7; 100_000];
    thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| store.put(&key('b'), &bytes).unwrap());
        }
    });
    assert!(store.get(&key('b'), 100_000).unwrap() == Fetched::Whole(bytes));
}

#[test]
fn pruning_keeps_the_latest_entries() {
    let store = in_memory();
    let entry = [&ENTRY_MAGIC[..], &[1; 2]].concat();
    for digit in '0'..='9' {
        store.put(&key(digit), &entry).unwrap();
        thread::sleep(std::time::Duration::from_millis(3));
    }
    let removed = store.prune(35).unwrap();
    assert_eq!((removed.entries, removed.bytes), (7, 70));
    assert_eq!(store.contents().unwrap().entries, 3);
    assert!(store.get(&key('6'), 10).unwrap() == Fetched::Nothing);
    assert!(store.get(&key('7'), 10).unwrap() == Fetched::Whole(entry));
}

/// A bucket may contain other files, and may be given by mistake.
#[test]
fn pruning_keeps_foreign_files() {
    let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
    let inner = Arc::new(InMemory::new());
    let store = StoreCache::new("memory".to_owned(), inner.clone(), Path::from("here")).unwrap();
    let rest = "a".repeat(62);
    let others = [
        "here/ab/notes.entry".to_owned(),
        format!("here/abc/{rest}.entry"),
        format!("here/AB/{rest}.entry"),
        format!("here/ab/{rest}a.entry"),
        format!("here/ab/{rest}.backup"),
        // Only the first bytes show that this file is not an entry.
        format!("here/ab/{rest}.entry"),
    ];
    for path in &others {
        runtime.block_on(inner.put(&Path::from(&**path), "mine, and not an entry".into())).unwrap();
    }
    store.put(&key('a'), ENTRY_MAGIC).unwrap();
    assert_eq!(store.prune(0).unwrap().entries, 1);
    for path in &others {
        assert!(runtime.block_on(inner.head(&Path::from(&**path))).is_ok(), "{path}");
    }
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn bakes_with_a_store_write_the_same_file() {
    bakes_write_the_same_file(&generate(GeneratedKind::City, 2), 2048);
}

#[test]
fn bakes_of_a_small_scene_with_a_store_write_the_same_file() {
    bakes_write_the_same_file(&generate(GeneratedKind::Primitives, 1), 1024);
}

fn bakes_write_the_same_file(scene: &Scene, resolution: u64) {
    let folder = tempfile::tempdir().unwrap();
    let url = format!("file://{}/a%20b", folder.path().display());
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(resolution));
    let mut fresh = Cursor::new(Vec::new());
    Bake::with_options(scene, &options).write_to(&mut fresh).unwrap();
    for number in 0..2 {
        std::fs::create_dir_all(folder.path().join("a b")).unwrap();
        let cache: Arc<dyn BakeCache> = Arc::new(StoreCache::open(&url).unwrap());
        let mut out = Cursor::new(Vec::new());
        let written =
            Bake::with_options(scene, &options).cache(Arc::clone(&cache)).write_to(&mut out).unwrap();
        assert!(out.into_inner() == *fresh.get_ref());
        let expected = if number == 0 { 0 } else { written.report.root_blocks };
        assert_eq!(written.report.reused_root_blocks, expected);
    }
}

#[test]
fn rejects_urls_that_name_no_store() {
    for (url, expected) in
        [("ftp://server/a", "ftp://server/a"), ("s3://", "s3:"), ("nonsense://x", "nonsense")]
    {
        let error = StoreCache::open(url).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("s3://bucket/prefix"), "{error}");
    }
}

/// An unreachable server is a temporary error, not an error of the input.
#[test]
fn unreachable_server_is_a_temporary_error() {
    // `StoreCache::open` installs the provider too, so another test may have installed it already.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let store = object_store::http::HttpBuilder::new()
        .with_url("http://127.0.0.1:9/entries")
        .with_client_options(object_store::ClientOptions::new().with_allow_http(true))
        .with_retry(object_store::RetryConfig {
            max_retries: 1,
            retry_timeout: std::time::Duration::from_secs(1),
            ..object_store::RetryConfig::default()
        })
        .build()
        .unwrap();
    let store =
        StoreCache::new("http://127.0.0.1:9/entries".to_owned(), Arc::new(store), Path::default()).unwrap();
    let error = store.get(&key('c'), 100).unwrap_err();
    let kind = error.source.kind();
    assert!(
        matches!(kind, std::io::ErrorKind::ConnectionRefused | std::io::ErrorKind::TimedOut),
        "{kind:?}: {error}"
    );
    assert!(error.to_string().contains("127.0.0.1:9"), "{error}");
}
