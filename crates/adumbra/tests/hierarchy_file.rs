//! Files whose layout is the hierarchy: written, read, refused when damaged, and looked up in as the graph is.

use std::sync::atomic::AtomicBool;

use adumbra::bake::{Options, Size, bake, bake_both, bake_hierarchy};
use adumbra::dag::{Slabs, Trail};
use adumbra::format::{Layout, LightBody, ShadowFile};
use adumbra::light::Sun;
use adumbra::scene::{GeneratedKind, Scene, generate};
use adumbra::verify::Random;

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

#[test]
fn damaged_shapes_of_a_bake_are_refused_or_give_one_answer_in_every_way() {
    let (_, file) = baked(&generate(GeneratedKind::City, 3), 256);
    let LightBody::Hierarchy(good) = &file.body else { panic!("another layout") };
    let mut random = Random::new(1, 0);
    let mut below = |n: usize| (random.unit() * n as f64) as usize;
    let (mut accepted, mut ranks) = (0, 0);
    for _ in 0..4000 {
        let mut damaged = good.clone();
        for _ in 0..1 + below(4) {
            let (at, shift) = (below(damaged.code.len()), 16 * below(2));
            let half = match below(4) {
                0 => below(1 << 16) as u32,
                1 => 0xffff,
                2 => damaged.code[below(good.code.len())] & 0xffff,
                _ => damaged.code[at] >> shift & 0xffff ^ 1 << below(16),
            };
            damaged.code[at] = damaged.code[at] & !(0xffff << shift) | half << shift;
        }
        if let Err(fault) = damaged.validate() {
            ranks += usize::from(fault.kind() == "Ranks");
            continue;
        }
        accepted += 1;
        for _ in 0..100 {
            let [i, j] = [0, 1].map(|a| below(damaged.size[a] as usize) as u32);
            let value = damaged.value(i, j);
            for k in [value.wrapping_sub(1), value, below(damaged.size[2] as usize) as u32] {
                let k = k.min(damaged.size[2] - 1);
                let lit = damaged.slab(i, j, k) >> ((j & 7) * 8 + (i & 7)) & 1 == 1;
                assert_eq!(lit, k < value, "({i}, {j}, {k}): {value}");
                let mut slabs = [0; 8];
                damaged.fill_along(&mut Trail::new(), [i, j, k], &mut slabs);
                assert_eq!(slabs[k as usize & 7], damaged.slab(i, j, k), "({i}, {j}, {k})");
            }
        }
    }
    assert!(accepted > 300 && ranks > 10, "{accepted} accepted, {ranks} with ranks");
}
