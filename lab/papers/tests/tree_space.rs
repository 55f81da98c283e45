//! The effect of boxes, sizes, biases and solids on the cube of a tree and the light's depth image, in
//! hand-made scenes.

use std::sync::atomic::AtomicBool;

use adumbra::{Bounds, RangeError, Sun};
use adumbra_bake::{BakeField, Error as BakeError, Size, Watch};
use adumbra_papers::tree::query::{TreeQuery, Weights};
use adumbra_papers::tree::{BakedTree, CaptureBias, Error, Reduction, TreeOptions, VoxelTree, bake_tree};
use adumbra_scene::{LoadOptions, Scene, load};

const UP: [f64; 3] = [0.0, 1.0, 0.0];

/// A scene of closed boxes, given by two corners each, and of flat squares at a height.
fn scene(boxes: &[[f64; 6]], squares: &[[f64; 3]]) -> Scene {
    let mut text = String::new();
    let mut vertices = 0;
    let mut add = |corners: &[[f64; 3]], faces: &[[usize; 3]]| {
        for [x, y, z] in corners {
            text += &format!("v {x} {y} {z}\n");
        }
        for [a, b, c] in faces {
            text += &format!("f {} {} {}\n", vertices + a, vertices + b, vertices + c);
        }
        vertices += corners.len();
    };
    for b in boxes {
        let corners: Vec<_> =
            (0..8).map(|i| [b[3 * (i >> 2)], b[1 + 3 * (i >> 1 & 1)], b[2 + 3 * (i & 1)]]).collect();
        let quads = [[1, 2, 4, 3], [5, 7, 8, 6], [1, 5, 6, 2], [3, 4, 8, 7], [1, 3, 7, 5], [2, 6, 8, 4]];
        let faces: Vec<_> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        add(&corners, &faces);
    }
    for [half, y, x] in squares {
        let corners =
            [[x - half, *y, -half], [x + half, *y, -half], [x + half, *y, *half], [x - half, *y, *half]];
        add(&corners, &[[1, 4, 3], [1, 3, 2]]);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.obj");
    std::fs::write(&path, text).unwrap();
    load(&path, &LoadOptions::default()).unwrap()
}

fn options(towards: [f64; 3], size: Size) -> TreeOptions {
    TreeOptions::new(Sun::from_direction(towards).unwrap(), size)
}

fn bake(scene: &Scene, options: &TreeOptions) -> BakedTree {
    bake_tree(scene, options, Watch::none()).unwrap()
}

fn query<'t>(baked: &'t BakedTree, sun: Sun) -> TreeQuery<'t, VoxelTree> {
    let bias = baked.settings.bias;
    TreeQuery::new(&baked.space, &baked.regions, &sun, &baked.tree, bias, 1, Weights::Mean).unwrap()
}

/// Returns the visibility of a point on the ground.
fn ground(baked: &BakedTree, towards: [f64; 3], x: f64, z: f64) -> f32 {
    query(baked, Sun::from_direction(towards).unwrap()).visibility([x, 0.0, z], Some(UP))
}

#[test]
fn tree_insides_of_solids_are_free_at_any_depth() {
    // A box below another one, both above the ground.
    let stacked =
        scene(&[[-2.1, 0.9, -2.2, 2.1, 3.1, 2.2], [-1.5, 5.0, -1.5, 1.5, 6.0, 1.5]], &[[8.0, 0.0, 0.0]]);
    let count = |closed_regions| {
        let size = Size::Resolution(128);
        let options =
            TreeOptions { closed_regions, reduction: Reduction::Sort, ..options([0.5, 0.8, 0.3], size) };
        bake(&stacked, &options)
    };
    let (free, defined) = (count(true), count(false));
    assert!(free.report.built_blocks < defined.report.built_blocks, "{:?} {:?}", free.report, defined.report);
    assert!(free.tree.bytes() < defined.tree.bytes());
    // On the sun's side, parts of the insides of the boxes are merged with the light around them.
    for [low, high] in [[[-1.5, 5.0, -1.5], [1.5, 6.0, 1.5]], [[-2.1, 0.9, -2.2], [2.1, 3.1, 2.2_f64]]] {
        let merged = (0..40_u32.pow(3)).any(|i| {
            let t = [i / 1600, i / 40 % 40, i % 40].map(|i| f64::from(i) / 40.0);
            let p_world = std::array::from_fn(|a| high[a] - 0.1 - t[a] * (high[a] - low[a] - 0.2));
            let xyz = free.space.to_tree(p_world).map(|c| c as u32);
            free.tree.voxel(xyz) && !defined.tree.voxel(xyz)
        });
        assert!(merged, "{low:?}");
    }
    // In the shadowed inside of the lower box the merged tree may have either visibility; outside, the two
    // trees agree.
    let side = free.space.side_voxels();
    for i in 0..20_000_u32 {
        let xyz = [i * 7919 % side, i * 104_729 % side, i * 1_299_709 % side];
        let p = free.space.to_world(xyz.map(|c| f64::from(c) + 0.5));
        let within = |b: [f64; 6]| (0..3).all(|a| b[a] <= p[a] && p[a] <= b[a + 3]);
        let solid = within([-2.1, 0.9, -2.2, 2.1, 3.1, 2.2]) || within([-1.5, 5.0, -1.5, 1.5, 6.0, 1.5]);
        assert!(solid || free.tree.voxel(xyz) == defined.tree.voxel(xyz), "{p:?}");
    }
    // A surface that is not closed is not a solid.
    let size = Size::Resolution(64);
    let open = scene(&[], &[[8.0, 0.0, 0.0], [2.0, 3.0, 0.0]]);
    let [with, without] = [true, false]
        .map(|closed_regions| bake(&open, &TreeOptions { closed_regions, ..options(UP, size) }).tree);
    assert!(with == without);
}

#[test]
fn tree_in_given_box_receives_shadows_from_outside() {
    // A wall outside the box on the sun's side, and a square high up and far away.
    let towards = [1.0, 0.5, 0.0];
    let wall = [6.0, 0.0, -3.0, 6.2, 4.0, 3.0];
    let world = scene(&[wall, [3000.0, 1400.0, -1.0, 3001.0, 1401.0, 1.0]], &[[4000.0, 0.0, 0.0]]);
    let bounds = Bounds { min: [0.0, -0.5, -4.0], max: [5.0, 2.0, 4.0] };
    let baked =
        bake(&world, &TreeOptions { bounds: Some(bounds), ..options(towards, Size::Resolution(512)) });
    assert!(baked.space.voxel_size < 0.02);
    let top = baked.space.to_world([512.0; 3]);
    assert!((0..3).all(|a| baked.space.p_min[a] < bounds.min[a] && bounds.max[a] < top[a]));
    // The wall is 4 m high. Its shadow is 8 m long, from x = 6 to -2, so it covers the box up to its rim.
    for x in [0.1, 1.0, 4.0, 4.95, 4.999] {
        assert_eq!(ground(&baked, towards, x, 0.0), 0.0, "{x}");
        assert_eq!(ground(&baked, towards, x, 3.5), 1.0, "{x}");
    }
    // The depths of the image begin at the cube, so the bake agrees with one of a scene without the distant
    // parts.
    let near = scene(&[wall], &[[40.0, 0.0, 0.0]]);
    let alone = bake(&near, &TreeOptions { bounds: Some(bounds), ..options(towards, Size::Resolution(512)) });
    assert_eq!(alone.space, baked.space);
    let differing = (0..40_000_u32)
        .map(|i| [i * 7919 % 512, i * 104_729 % 512, i * 1_299_709 % 512])
        // At the ground itself a voxel's centre may be on either side.
        .filter(|xyz| (alone.space.to_world(xyz.map(|c| f64::from(c) + 0.5))[1]).abs() > 0.05)
        .filter(|xyz| alone.tree.voxel(*xyz) != baked.tree.voxel(*xyz))
        .count();
    assert!(differing < 40, "{differing}");
}

#[test]
fn tree_has_requested_voxel_size() {
    let world = scene(&[[-1.0, 0.0, -1.0, 1.0, 2.0, 1.0]], &[[5.0, 0.0, 0.0]]);
    let baked = bake(&world, &options(UP, Size::VoxelSize(0.1)));
    assert_eq!((baked.space.voxel_size, baked.space.depth), (0.1, 7));
    // The cube is centred on the scene.
    assert!((baked.space.p_min[0] + 6.4).abs() < 1e-9 && (baked.space.p_min[1] - 1.0 + 6.4).abs() < 1e-9);
    assert_eq!([0.0, 3.0].map(|x| ground(&baked, UP, x, 0.0)), [0.0, 1.0]);
    for size in [0.0, -1.0, f64::NAN, 1e-9] {
        let refused = bake_tree(&world, &options(UP, Size::VoxelSize(size)), Watch::none());
        let Err(Error::Bake(BakeError::Range(RangeError { field, .. }))) = refused else { panic!("{size}") };
        assert_eq!(field, BakeField::VoxelSize, "{size}");
    }
}

#[test]
fn tree_capture_bias_moves_depths_away_from_the_light() {
    // A flat square. A bias of 16 texels, two per voxel edge, moves its shadow 8 voxels away from it.
    let world = scene(&[], &[[5.0, 0.0, 0.0], [1.0, 2.0, 0.0]]);
    let lit_below = |constant_texels: f64, slope_texels: f64, towards: [f64; 3]| {
        let capture_bias = CaptureBias { constant_texels, slope_texels };
        let baked = bake(&world, &TreeOptions { capture_bias, ..options(towards, Size::Resolution(128)) });
        // The depth of the highest shadowed voxel under the square, in voxels below it.
        let [x, _, z] = baked.space.to_tree([0.0; 3]).map(|c| c as u32);
        let top = baked.space.to_tree([0.0, 2.0, 0.0])[1] as u32;
        (0..40).find(|d| !baked.tree.voxel([x, top - d, z])).unwrap()
    };
    assert!(lit_below(0.0, 0.0, UP) <= 1);
    assert!((8..=9).contains(&lit_below(16.0, 0.0, UP)), "{}", lit_below(16.0, 0.0, UP));
    // With the sun overhead there is no slope. At 45 degrees the slope is 1, and depth along the light grows
    // √2 times as fast as height does.
    assert!(lit_below(0.0, 16.0, UP) <= 1);
    assert!(
        (5..=7).contains(&lit_below(0.0, 16.0, [1.0, 1.0, 0.0])),
        "{}",
        lit_below(0.0, 16.0, [1.0, 1.0, 0.0])
    );
    let refused = |constant_texels, slope_texels| {
        let capture_bias = CaptureBias { constant_texels, slope_texels };
        let options = TreeOptions { capture_bias, ..options(UP, Size::Resolution(64)) };
        bake_tree(&world, &options, Watch::none()).is_err()
    };
    assert!(refused(-0.1, 0.0) && refused(0.0, 16.5) && refused(f64::NAN, 0.0));
}

#[test]
fn tree_answers_points_with_nan_normal() {
    let world = scene(&[[-1.0, 0.0, -1.0, 1.0, 2.0, 1.0]], &[[5.0, 0.0, 0.0]]);
    let baked = bake(&world, &options(UP, Size::Resolution(64)));
    let query = query(&baked, Sun::from_direction(UP).unwrap());
    // Under the box it is as dark as without a normal.
    assert_eq!(query.visibility([0.0; 3], Some([f64::NAN; 3])), 0.0);
    let nan = [f64::NAN, 0.0, 0.0];
    assert!(query.voxel_at([0.0; 3], None).is_some());
    assert_eq!(query.voxel_at([0.0; 3], Some(nan)), query.voxel_at([0.0; 3], None));
}

#[test]
fn tree_bake_stops_at_memory_limit_and_on_cancel() {
    let world = scene(&[[-1.0, 0.0, -1.0, 1.0, 2.0, 1.0]], &[[5.0, 0.0, 0.0]]);
    let small = TreeOptions { max_memory_bytes: Some(1 << 20), ..options(UP, Size::Resolution(1024)) };
    let refused = bake_tree(&world, &small, Watch::none());
    assert!(matches!(refused, Err(Error::Bake(BakeError::MemoryLimit { .. }))));
    let cancelled = AtomicBool::new(true);
    let stopped = bake_tree(&world, &options(UP, Size::Resolution(64)), Watch::new(&|_| {}, &cancelled));
    assert!(matches!(stopped, Err(Error::Bake(BakeError::Interrupted))));
}
