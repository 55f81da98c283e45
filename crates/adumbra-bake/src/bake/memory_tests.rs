//! Bakes within a memory limit: they give the same bytes as without one, whatever goes to disk, or an error that says
//! why not.

use adumbra::{IoError, Layout, LightBody, Sun};
use adumbra_scene::{GeneratedKind, Scene, generate};

use crate::convert::body_in;
use crate::error::{Error, Result};
use crate::options::{BakeOptions, Builder, FrameChoice, LayoutChoice, Size};
use crate::progress::{Report, Watch};
use crate::test_bakes::{bake_both, bake_depths, bake_graph};

/// The light's frame, in which files are large enough to be spilled.
fn options(resolution: u64) -> BakeOptions {
    let sun = Sun::from_direction([-0.45, 0.75, -0.35]).unwrap();
    BakeOptions { frame: FrameChoice::Light, ..BakeOptions::new(sun, Size::Resolution(resolution)) }
}

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// Bisects the smallest memory limit that a bake fits into. Returns the most bytes spilled to disk on the way.
fn squeeze<T: Send + PartialEq>(
    options: &BakeOptions,
    bake: impl Fn(&BakeOptions) -> Result<(T, Report)> + Sync,
) -> u64 {
    let (expected, free) = on_threads(2, || bake(options)).unwrap();
    assert_eq!(free.spilled_bytes, 0);
    let (mut too_little, mut enough) = (0, free.accounted_bytes * 5 / 4);
    let mut most_spilled = 0;
    for step in 0..8 {
        let limit = (too_little + enough) / 2;
        let options = BakeOptions { max_memory_bytes: Some(limit), ..options.clone() };
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

fn bake_packed(scene: &Scene, options: &BakeOptions) -> Result<(LightBody, Report)> {
    let options = BakeOptions { layout: LayoutChoice::Packed, ..options.clone() };
    let baked = crate::bake(scene, &options, Watch::none())?;
    Ok((baked.file.body, baked.report))
}

fn city() -> Scene {
    generate(GeneratedKind::City, 3)
}

#[test]
#[ignore = "slow: bakes again and again"]
fn limited_bake_gives_the_graph_of_a_free_one() {
    let scene = city();
    for (builder, resolution) in [(Builder::Fast, 2048), (Builder::Plain, 1024)] {
        let options = BakeOptions { builder, ..options(resolution) };
        let spilled = squeeze(&options, |o| bake_graph(&scene, o).map(|b| (b.dag, b.report)));
        assert!(spilled > 0, "{builder:?}");
    }
}

#[test]
#[ignore = "slow: bakes again and again"]
fn limited_bake_gives_the_packed_graph_of_a_free_one() {
    let scene = city();
    let options = options(2048);
    let packed = |o: &BakeOptions| bake_packed(&scene, o);
    assert!(squeeze(&options, packed) > 0);
    let dag = bake_graph(&scene, &options).unwrap().dag;
    assert!(body_in(Layout::Packed, dag).unwrap() == packed(&options).unwrap().0);
}

#[test]
#[ignore = "slow: bakes again and again"]
fn limited_bake_gives_the_depths_of_a_free_one() {
    let scene = city();
    for merged in [true, false] {
        let spilled = squeeze(&options(8192), |o| bake_depths(&scene, o, merged));
        assert!(spilled > 0, "{merged}");
    }
    let spilled = squeeze(&options(2048), |o| bake_both(&scene, o));
    assert!(spilled > 0);
}

#[test]
#[ignore = "slow: bakes again and again"]
fn limited_bake_without_a_folder_to_spill_to_is_an_error() {
    let scene = city();
    let folder = std::path::PathBuf::from("/nonexistent/adumbra");
    let (_, free) = bake_packed(&scene, &options(2048)).unwrap();
    let mut failed = 0;
    for step in 0..16 {
        let limit = free.accounted_bytes * (24 - step) / 20;
        let options = BakeOptions {
            max_memory_bytes: Some(limit),
            spill_folder: Some(folder.clone()),
            ..options(2048)
        };
        match bake_packed(&scene, &options) {
            Ok((_, report)) => assert_eq!(report.spilled_bytes, 0, "{limit}"),
            Err(Error::MemoryLimit { .. }) => {}
            Err(Error::Spill(IoError { path, source, .. })) => {
                assert_eq!((path, source.kind()), (folder.clone(), std::io::ErrorKind::NotFound));
                failed += 1;
            }
            Err(error) => panic!("{error}"),
        }
    }
    assert!(failed > 0);
}

#[test]
#[ignore = "slow: bakes again and again"]
fn baking_both_gives_what_baking_each_gives() {
    let sun = Sun::from_direction([-0.3, 0.6, 0.7]).unwrap();
    for kind in [GeneratedKind::City, GeneratedKind::Landscape] {
        let scene = generate(kind, 2);
        let options = BakeOptions { thickness_world: 0.1, ..BakeOptions::new(sun, Size::Resolution(512)) };
        let (both, report) = bake_both(&scene, &options).unwrap();
        let graph = bake_graph(&scene, &options).unwrap();
        let (depths, _) = bake_depths(&scene, &options, true).unwrap();
        assert!(both == (graph.dag, depths), "{kind:?}");
        assert_eq!(report.drawn_texels, graph.report.drawn_texels);
        assert!(report.accounted_bytes >= graph.report.accounted_bytes);
        let options = BakeOptions { max_memory_bytes: Some(graph.report.accounted_bytes / 2), ..options };
        assert!(matches!(bake_both(&scene, &options), Err(Error::MemoryLimit { .. })), "{kind:?}");
    }
}
