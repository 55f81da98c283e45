//! Bakes within a memory limit: they give the same bytes as without one, whatever goes to disk, or an error
//! that says why not.

use std::sync::Arc;

use adumbra::layout::depths::DepthTree;
use adumbra::{IoError, Sun};
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_testing::full;

use crate::choose;
use crate::error::{Error, Result};
use crate::options::{BakeOptions, ColumnBuilder, FrameChoice, Size};
use crate::pages::PageStore;
use crate::progress::Report;
use crate::test_bakes::bake_depths;

/// The light's frame, in which files are large enough to be spilled.
fn options(resolution: u64) -> BakeOptions {
    let sun = Sun::from_direction([-0.45, 0.75, -0.35]).unwrap();
    BakeOptions { frame: FrameChoice::Light, ..BakeOptions::new(sun, Size::Resolution(resolution)) }
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// Bisects the smallest memory limit that a bake fits into, in so many steps, on these numbers of threads in
/// turn. Returns the most bytes spilled to disk on the way.
fn squeeze(
    options: &BakeOptions,
    threads: &[usize],
    steps: usize,
    bake: impl Fn(&BakeOptions) -> Result<(DepthTree, Report)> + Sync,
) -> u64 {
    let (expected, free) = on_threads(threads[threads.len() - 1], || bake(options)).unwrap();
    assert_eq!(free.spilled_bytes, 0);
    let (mut too_little, mut enough) = (0, free.accounted_bytes * 5 / 4);
    let mut most_spilled = 0;
    for step in 0..steps {
        let limit = (too_little + enough) / 2;
        let options = BakeOptions { max_memory_bytes: Some(limit), ..options.clone() };
        match on_threads(threads[step % threads.len()], || bake(&options)) {
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
#[ignore = "slow: bakes again and again"]
fn limited_bake_gives_the_depths_of_a_free_one() {
    let (fast, steps) = if full() { (8192, 8) } else { (4096, 5) };
    let cases = [
        (ColumnBuilder::Fast, fast, true),
        (ColumnBuilder::Fast, fast, false),
        (ColumnBuilder::Plain, 512, true),
    ];
    limited_bakes_give_the_depths_of_free_ones(&city(), &cases, &[1, 2], steps);
}

#[test]
fn limited_bake_of_few_pages_gives_the_depths_of_a_free_one() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let cases = [(ColumnBuilder::Fast, 1024, true), (ColumnBuilder::Plain, 128, true)];
    // In so many steps the last limits are apart by less than a page. Another thread would take more than all
    // pages.
    limited_bakes_give_the_depths_of_free_ones(&scene, &cases, &[1], 10);
}

#[test]
fn what_finishing_needs_stays_free_while_pages_are_added() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let limited = |limit| BakeOptions { max_memory_bytes: Some(limit), ..options(256) };
    let baking_bytes = choose::plan(&scene, &limited(1 << 30)).unwrap().baking_bytes();
    let limit = baking_bytes + 100;
    let plan = on_threads(1, || choose::plan(&scene, &limited(limit))).unwrap();
    let store = PageStore::new(Arc::clone(&plan.spill));
    let (held_bytes, page) = (20, vec![0; 4]);
    plan.limit_pages_while_building(held_bytes, 0);
    let room = limit - plan.baking_bytes() - held_bytes;
    (0..room / 16 + 1).for_each(|_| _ = store.add(0, page.clone()));
    assert_eq!(plan.paged_bytes().unwrap(), room / 16 * 16);
    plan.limit_pages_while_building(held_bytes, limit - plan.scene_bytes - held_bytes - 32);
    store.shrink();
    assert_eq!(plan.paged_bytes().unwrap(), 32);
}

/// Bakes with each builder and resolution, with equal shapes stored once or not.
fn limited_bakes_give_the_depths_of_free_ones(
    scene: &Scene,
    cases: &[(ColumnBuilder, u64, bool)],
    threads: &[usize],
    steps: usize,
) {
    for &(builder, resolution, merged) in cases {
        let options = BakeOptions { builder, ..options(resolution) };
        let spilled = squeeze(&options, threads, steps, |o| bake_depths(scene, o, merged));
        // The plain builder's columns take more memory than its depths.
        assert!(spilled > 0 || builder == ColumnBuilder::Plain, "{builder:?}, {merged}");
    }
}

#[test]
#[ignore = "slow: bakes again and again"]
fn limited_bake_without_a_folder_to_spill_to_is_an_error() {
    without_a_folder_to_spill_to_is_an_error(&city(), 2048, |_, free| {
        (0..8).map(|step| free.accounted_bytes * (24 - 2 * step) / 20).collect()
    });
}

#[test]
fn limited_bake_of_few_pages_without_a_folder_to_spill_to_is_an_error() {
    let scene = generate(GeneratedKind::Primitives, 1);
    // From where all pages have room to where none has.
    let limits = |tree: &DepthTree, free: &Report| -> Vec<u64> {
        let quarter_bytes = tree.code().len() as u64;
        (0..=8).map(|step| free.accounted_bytes + 4 * quarter_bytes - step * quarter_bytes).collect()
    };
    on_threads(1, || without_a_folder_to_spill_to_is_an_error(&scene, 1024, limits));
}

/// Bakes within the limits that `limits` makes of what a free bake gives.
fn without_a_folder_to_spill_to_is_an_error(
    scene: &Scene,
    resolution: u64,
    limits: impl Fn(&DepthTree, &Report) -> Vec<u64>,
) {
    let folder = std::path::PathBuf::from("/nonexistent/adumbra");
    let options = options(resolution);
    let (tree, free) = bake_depths(scene, &options, true).unwrap();
    let limits = limits(&tree, &free);
    let mut failed = 0;
    for &limit in &limits {
        let options = BakeOptions {
            max_memory_bytes: Some(limit),
            spill_folder: Some(folder.clone()),
            ..options.clone()
        };
        match bake_depths(scene, &options, true) {
            Ok((_, report)) => assert_eq!(report.spilled_bytes, 0, "{limit}"),
            Err(Error::MemoryLimit { .. }) => {}
            Err(Error::Spill(IoError { path, source, .. })) => {
                assert_eq!((path, source.kind()), (folder.clone(), std::io::ErrorKind::NotFound));
                failed += 1;
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert!(failed > 0, "a free bake takes {} bytes; at {limits:?} none spills", free.accounted_bytes);
}
