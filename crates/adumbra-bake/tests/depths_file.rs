//! Files that hold depths: written, read back, refused if damaged, and queried like the graph. Also the choice of the
//! smaller of two layouts.

use adumbra::layout::{LeafMasks, Trail};
use adumbra::{Layout, LightBody, ShadowFile, Sun};
use adumbra_bake::convert::graph_of;
use adumbra_bake::{Bake, BakeOptions, Error, LayoutChoice, Size, Watch, bake};
use adumbra_files::replace_file;
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, Scene, generate};

fn baked(scene: &Scene, resolution: u64) -> (ShadowFile, ShadowFile) {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(resolution));
    let [graph, depths] = [LayoutChoice::Plain, LayoutChoice::Depths]
        .map(|layout| bake_in(layout, scene, &options).unwrap().file);
    assert_eq!((graph.grid, graph.settings), (depths.grid, depths.settings));
    (graph, depths)
}

fn bake_in(layout: LayoutChoice, scene: &Scene, options: &BakeOptions) -> Result<Bake, Error> {
    bake(scene, &BakeOptions { layout, ..options.clone() }, Watch::none())
}

#[test]
fn depths_file_is_read_as_it_was_written_and_is_smaller() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.adumbra");
    let (graph, file) = baked(&generate(GeneratedKind::City, 3), 1024);
    let bytes = replace_file(&path, |out| file.write_to(out)).unwrap();
    let again = ShadowFile::read(&path).unwrap();
    assert_eq!(again, file);
    assert_eq!(again.body.layout(), Layout::Depths);
    assert_eq!(again.body.composition().unwrap(), file.body.composition().unwrap());
    assert!(2 * bytes < graph.body.encoded_len(), "{bytes}");
    // Readers that support only the graph get one that gives the same answers.
    let (LightBody::Depths(depths), dag) = (&file.body, graph_of(&file.body).unwrap()) else {
        panic!("{bytes}")
    };
    for at in 0..20_000_u32 {
        let [x, y, z] =
            [0, 1, 2].map(|a| at.wrapping_mul([2_654_435_761, 40_503, 2_246_822_519][a]) % file.grid.size[a]);
        assert_eq!(dag.voxel(x, y, z), z < depths.value(x, y), "{x} {y} {z}");
    }
}

#[test]
fn smaller_of_both_layouts_is_that_of_a_bake_of_its_own() {
    let sun = Sun::from_direction([-0.3, 0.6, 0.7]).unwrap();
    for kind in [GeneratedKind::City, GeneratedKind::Landscape] {
        let scene = generate(kind, 2);
        let options = BakeOptions { thickness_world: 0.1, ..BakeOptions::new(sun, Size::Resolution(512)) };
        let auto = bake_in(LayoutChoice::Auto, &scene, &options).unwrap();
        let packed = bake_in(LayoutChoice::Packed, &scene, &options).unwrap();
        let depths = bake_in(LayoutChoice::Depths, &scene, &options).unwrap();
        let candidates = auto.candidates.expect("two layouts were requested");
        let [packed_bytes, depths_bytes] = [&packed, &depths].map(|bake| bake.file.body.encoded_len());
        assert_eq!((candidates.packed, candidates.depths), (Some(packed_bytes), depths_bytes));
        assert_eq!((packed.candidates, depths.candidates), (None, None));
        let smaller = if packed_bytes < depths_bytes { &packed } else { &depths };
        assert!(auto.file == smaller.file, "{kind:?}");
        assert_eq!(auto.report.drawn_texels, packed.report.drawn_texels);
        let limit = Some(packed.report.accounted_bytes / 2);
        let refused =
            bake_in(LayoutChoice::Auto, &scene, &BakeOptions { max_memory_bytes: limit, ..options });
        assert!(matches!(refused, Err(Error::MemoryLimit { .. })), "{kind:?}");
    }
}

#[test]
fn depths_file_that_is_cut_or_changed_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spheres.adumbra");
    let (_, file) = baked(&generate(GeneratedKind::Spheres, 3), 64);
    let mut bytes = Vec::new();
    file.write_to(&mut bytes).unwrap();
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
    let LightBody::Depths(good) = &file.body else { panic!("another layout") };
    let mut random = Random::for_batch(1, 0);
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
                assert_eq!(damaged.voxel(i, j, k), k < value, "({i}, {j}, {k}): {value}");
                let mut leaf_masks = [0; 8];
                damaged.fill(&mut Trail::new(), [i, j, k], &mut leaf_masks);
                assert_eq!(leaf_masks[k as usize & 7], damaged.look_up(i, j, k), "({i}, {j}, {k})");
            }
        }
    }
    assert!(accepted > 300 && ranks > 10, "{accepted} accepted, {ranks} with ranks");
}
