//! Files whose layout is the hierarchy: written, read, refused when damaged, and looked up in as the graph is.

use std::sync::atomic::AtomicBool;

use adumbra::bake::{Options, Size, bake, bake_both, bake_hierarchy};
use adumbra::format::{Layout, LightBody, ShadowFile};
use adumbra::light::Sun;
use adumbra::scene::{GeneratedKind, Scene, generate};

fn baked(scene: &Scene, resolution: u64) -> (ShadowFile, ShadowFile) {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = Options::new(sun, Size::Resolution(resolution));
    let never = AtomicBool::new(false);
    let graph = bake(scene, &options, &|_| {}, &never).unwrap();
    let found = bake_hierarchy(scene, &options, true, &|_| {}, &never).unwrap();
    assert_eq!((graph.grid, graph.settings), (found.grid, found.settings));
    (
        ShadowFile::plain(graph.grid, graph.settings, graph.dag),
        ShadowFile::hierarchy(found.grid, found.settings, found.hierarchy),
    )
}

#[test]
fn hierarchy_file_is_read_as_it_was_written_and_is_smaller() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.adumbra");
    let (graph, file) = baked(&generate(GeneratedKind::City, 3), 1024);
    let bytes = file.write(&path).unwrap();
    let again = ShadowFile::read(&path).unwrap();
    assert_eq!(again, file);
    assert_eq!(again.body.layout(), Layout::Hierarchy);
    assert_eq!(again.body.composition().unwrap(), file.body.composition().unwrap());
    assert!(2 * bytes < graph.write(folder.path().join("graph.adumbra")).unwrap(), "{bytes}");
    // What reads the graph alone gets one that answers alike.
    let (LightBody::Hierarchy(hierarchy), dag) = (&file.body, file.graph().unwrap()) else {
        panic!("{bytes}")
    };
    for at in 0..20_000_u32 {
        let [x, y, z] =
            [0, 1, 2].map(|a| at.wrapping_mul([2_654_435_761, 40_503, 2_246_822_519][a]) % file.grid.size[a]);
        assert_eq!(dag.voxel(x, y, z), z < hierarchy.value(x, y), "{x} {y} {z}");
    }
}

#[test]
fn baking_both_gives_what_baking_each_gives() {
    let sun = Sun::from_direction([-0.3, 0.6, 0.7]).unwrap();
    let never = AtomicBool::new(false);
    for kind in [GeneratedKind::City, GeneratedKind::Landscape] {
        let scene = generate(kind, 2);
        let options = Options { thickness_world: 0.1, ..Options::new(sun, Size::Resolution(512)) };
        let both = bake_both(&scene, &options, &|_| {}, &never).unwrap();
        let graph = bake(&scene, &options, &|_| {}, &never).unwrap();
        let hierarchy = bake_hierarchy(&scene, &options, true, &|_| {}, &never).unwrap();
        assert!(both.dag == graph.dag && both.hierarchy == hierarchy.hierarchy, "{kind:?}");
        assert_eq!((both.grid, both.settings), (graph.grid, graph.settings));
        assert_eq!(both.report.drawn_texels, graph.report.drawn_texels);
        assert!(both.report.accounted_bytes >= graph.report.accounted_bytes);
        let options = Options { max_memory_bytes: Some(graph.report.accounted_bytes / 2), ..options };
        let refused = bake_both(&scene, &options, &|_| {}, &never);
        assert!(matches!(refused, Err(adumbra::Error::MemoryLimit { .. })), "{kind:?}");
    }
}

#[test]
fn hierarchy_file_that_is_cut_or_changed_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spheres.adumbra");
    let (_, file) = baked(&generate(GeneratedKind::Spheres, 3), 64);
    file.write(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let refused = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        ShadowFile::read(&path).is_err()
    };
    for length in 0..bytes.len() {
        assert!(refused(&bytes[..length]), "{length}");
    }
    for at in 0..bytes.len() {
        let mut changed = bytes.clone();
        changed[at] ^= 1 << (at & 7);
        assert!(refused(&changed), "{at}");
    }
}
