//! Entries in stores. The server of S3 is in `python/tests`, because it comes with Python.

use std::io::Cursor;
use std::sync::Arc;
use std::thread;

use adumbra::Sun;
use adumbra_bake::{
    BakeCache, BakeOptions, CacheKey, ENTRY_MAGIC, Fetched, Size, Watch, bake_to, bake_with_cache,
};
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
fn entries_are_stored_and_damaged_ones_are_replaced() {
    let store = in_memory();
    assert_eq!(store.get(&key('a'), 5).unwrap(), Fetched::Nothing);
    store.put(&key('a'), b"first").unwrap();
    store.put(&key('a'), b"first").unwrap();
    assert_eq!(store.get(&key('a'), 5).unwrap(), Fetched::Whole(b"first".to_vec()));
    // Whoever puts other bytes has found the entry damaged.
    store.put(&key('a'), b"whole").unwrap();
    assert_eq!(store.get(&key('a'), 5).unwrap(), Fetched::Whole(b"whole".to_vec()));
    assert_eq!(store.get(&key('a'), 4).unwrap(), Fetched::TooLong(5));
    let all = store.contents().unwrap().contents;
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
    let removed = store.prune(35).unwrap().contents;
    assert_eq!((removed.entries, removed.bytes), (7, 70));
    assert_eq!(store.contents().unwrap().contents.entries, 3);
    assert!(store.get(&key('6'), 10).unwrap() == Fetched::Nothing);
    assert!(store.get(&key('7'), 10).unwrap() == Fetched::Whole(entry));
}

/// A bucket may have other things in it, and be given by mistake.
#[test]
fn foreign_objects_are_not_removed() {
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
        // Only its first bytes tell.
        format!("here/ab/{rest}.entry"),
    ];
    for path in &others {
        runtime.block_on(inner.put(&Path::from(&**path), "mine, and not an entry".into())).unwrap();
    }
    store.put(&key('a'), ENTRY_MAGIC).unwrap();
    assert_eq!(store.prune(0).unwrap().contents.entries, 1);
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
    bake_to(scene, &options, Watch::none(), &mut fresh).unwrap();
    for number in 0..2 {
        std::fs::create_dir_all(folder.path().join("a b")).unwrap();
        let cache: Arc<dyn BakeCache> = Arc::new(StoreCache::open(&url).unwrap());
        let mut out = Cursor::new(Vec::new());
        let written = bake_with_cache(scene, &options, &cache, Watch::none(), &mut out).unwrap();
        assert!(out.into_inner() == *fresh.get_ref());
        let expected = if number == 0 { 0 } else { written.report.root_blocks };
        assert_eq!(written.report.reused_root_blocks, expected);
    }
}

#[test]
fn urls_that_are_no_stores_are_errors() {
    for (url, expected) in
        [("ftp://server/a", "ftp://server/a"), ("s3://", "s3:"), ("nonsense://x", "nonsense")]
    {
        let error = StoreCache::open(url).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("s3://bucket/prefix"), "{error}");
    }
}

/// A server that is not there is a matter of time, not of the input.
#[test]
fn servers_that_are_away_can_be_asked_again() {
    // As `StoreCache::open` does. Another test may have done it already.
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
