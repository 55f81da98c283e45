//! Bakes within a memory limit: the same bytes as without, whatever goes to disk, or an error that says why not.

use std::sync::atomic::AtomicBool;

use adumbra::Error;
use adumbra::bake::{Builder, Options, Report, Size, bake, bake_both, bake_hierarchy, bake_packed};
use adumbra::dag::packed::PackedDag;
use adumbra::light::Sun;
use adumbra::scene::{GeneratedKind, Scene, generate};

static NEVER: AtomicBool = AtomicBool::new(false);

fn options(resolution: u64) -> Options {
    Options::new(Sun::from_direction([-0.45, 0.75, -0.35]).unwrap(), Size::Resolution(resolution))
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// Halves its way to the least memory that a bake fits; the most that went to disk on the way.
fn squeeze<T: Send + PartialEq>(
    options: &Options,
    bake: impl Fn(&Options) -> Result<(T, Report), Error> + Sync,
) -> u64 {
    let (expected, free) = on_threads(2, || bake(options)).unwrap();
    assert_eq!(free.spilled_bytes, 0);
    let (mut too_little, mut enough) = (0, free.accounted_bytes * 5 / 4);
    let mut most_spilled = 0;
    for step in 0..8 {
        let limit = (too_little + enough) / 2;
        let options = Options { max_memory_bytes: Some(limit), ..options.clone() };
        match on_threads(1 + step % 2, || bake(&options)) {
            Ok((found, report)) => {
                assert!(found == expected, "{limit} of {}", free.accounted_bytes);
                assert!(report.accounted_bytes <= limit, "{report:?}");
                most_spilled = most_spilled.max(report.spilled_bytes);
                enough = limit;
            }
            Err(Error::MemoryLimit { needed_bytes, limit_bytes, .. }) => {
                assert!(limit_bytes == limit && needed_bytes > limit);
                too_little = limit;
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert!(too_little > 0, "nothing is too little");
    most_spilled
}

fn city() -> Scene {
    generate(GeneratedKind::City, 3)
}

#[test]
fn limited_bake_gives_the_graph_of_a_free_one() {
    let scene = city();
    for (builder, resolution) in [(Builder::Fast, 2048), (Builder::Plain, 1024)] {
        let options = Options { builder, ..options(resolution) };
        let spilled = squeeze(&options, |o| bake(&scene, o, &|_| {}, &NEVER).map(|b| (b.dag, b.report)));
        assert!(spilled > 0, "{builder:?}");
    }
}

#[test]
fn limited_bake_gives_the_packed_graph_of_a_free_one() {
    let scene = city();
    let options = options(2048);
    let packed = |o: &Options| bake_packed(&scene, o, &|_| {}, &NEVER).map(|b| (b.packed, b.report));
    assert!(squeeze(&options, packed) > 0);
    let dag = bake(&scene, &options, &|_| {}, &NEVER).unwrap().dag;
    assert!(PackedDag::of_dag(&dag).unwrap() == packed(&options).unwrap().0);
}

#[test]
fn limited_bake_gives_the_hierarchy_of_a_free_one() {
    let scene = city();
    for merged in [true, false] {
        let spilled = squeeze(&options(2048), |o| {
            bake_hierarchy(&scene, o, merged, &|_| {}, &NEVER).map(|b| (b.hierarchy, b.report))
        });
        assert!(spilled > 0, "{merged}");
    }
    let spilled = squeeze(&options(2048), |o| {
        bake_both(&scene, o, &|_| {}, &NEVER).map(|b| ((b.dag, b.hierarchy), b.report))
    });
    assert!(spilled > 0);
}

#[test]
fn limited_bake_without_a_folder_to_spill_to_is_an_error() {
    let scene = city();
    let folder = std::path::PathBuf::from("/nonexistent/adumbra");
    let free = bake_packed(&scene, &options(2048), &|_| {}, &NEVER).unwrap().report;
    let mut failed = 0;
    for step in 0..16 {
        let limit = free.accounted_bytes * (24 - step) / 20;
        let options =
            Options { max_memory_bytes: Some(limit), spill_folder: Some(folder.clone()), ..options(2048) };
        match bake_packed(&scene, &options, &|_| {}, &NEVER) {
            Ok(baked) => assert_eq!(baked.report.spilled_bytes, 0, "{limit}"),
            Err(Error::MemoryLimit { .. }) => {}
            Err(Error::Io { path, source, .. }) => {
                assert_eq!((path, source.kind()), (folder.clone(), std::io::ErrorKind::NotFound));
                failed += 1;
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert!(failed > 0);
}
