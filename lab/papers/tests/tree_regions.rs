//! Regions of several depths in one tree: the requested depth in each region, and no seams between them.

use adumbra::Sun;
use adumbra_bake::{Size, Watch};
use adumbra_papers::tree::query::{TreeQuery, Weights};
use adumbra_papers::tree::{BakedTree, Detail, Region, TreeAnswers, TreeOptions, VoxelTree, bake_tree};
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{Answers, Replaced, Sampler, Solids, SurfaceSampler, Verifier, VerifyOptions};

const SUN: [f64; 3] = [0.5, 0.8, 0.35];

fn sun() -> Sun {
    Sun::from_direction(SUN).unwrap()
}

fn bake(scene: &Scene, depth: u32, detail: Detail) -> BakedTree {
    let options = TreeOptions { detail, ..TreeOptions::new(sun(), Size::Resolution(1_u64 << depth)) };
    bake_tree(scene, &options, Watch::none()).unwrap()
}

fn query(baked: &BakedTree, kernel_side: u32) -> TreeQuery<'_, VoxelTree> {
    let (bias, weights) = (baked.settings.bias, Weights::Mean);
    TreeQuery::new(&baked.space, &baked.regions, &sun(), &baked.tree, bias, kernel_side, weights).unwrap()
}

#[test]
fn tree_region_has_the_voxels_of_a_whole_tree_of_its_depth() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let region = Region { x: [-6.0, 5.0], z: [-4.0, 7.0], depth: 9 };
    let mixed = bake(&scene, 7, Detail::Regions(vec![region]));
    let whole = bake(&scene, 9, Detail::Uniform);
    assert_eq!(mixed.space, whole.space);
    assert!(mixed.tree.bytes() < whole.tree.bytes());
    let voxels = mixed.regions.in_voxels(&mixed.space)[0];
    let mut coarse_cells = 0;
    for x in (0..512).step_by(3) {
        for y in (0..512).step_by(5) {
            for z in (0..512).step_by(3) {
                let inside =
                    (voxels.x[0]..voxels.x[1]).contains(&x) && (voxels.z[0]..voxels.z[1]).contains(&z);
                if inside {
                    assert_eq!(mixed.tree.voxel([x, y, z]), whole.tree.voxel([x, y, z]), "{x} {y} {z}");
                } else if mixed.tree.find([x, y, z]).1 == 2 {
                    coarse_cells += 1;
                }
                // Outside, a cell next to the region may be finer than 4 voxels, but a distant one may not.
                let far = x + 4 < voxels.x[0] || x >= voxels.x[1] + 4;
                assert!(!far || mixed.tree.find([x, y, z]).1 >= 2, "{x} {y} {z}");
            }
        }
    }
    assert!(coarse_cells > 0);
}

#[test]
fn tree_rings_nest_like_cascades() {
    let scene = generate(GeneratedKind::Landscape, 1);
    let rings = Detail::Rings { center_xz: [3.0, -5.0], radii: vec![10.0, 20.0, 40.0] };
    let baked = bake(&scene, 10, rings);
    let depths: Vec<_> = baked.regions.list.iter().map(|r| r.depth).collect();
    assert_eq!((depths, baked.regions.base_depth), (vec![10, 9, 8], 7));
    assert_eq!(baked.regions.list[1].x, [-17.0, 23.0]);
    let query = query(&baked, 1);
    let size = |x: f64| query.voxel_size_at([x, 0.0, -5.0], None) / baked.space.voxel_size;
    assert_eq!([3.0, 18.0, 38.0, 60.0].map(size), [1.0, 2.0, 4.0, 8.0]);
}

#[test]
fn tree_rejects_invalid_regions() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let refused = |detail, depth: u32| {
        let options = TreeOptions { detail, ..TreeOptions::new(sun(), Size::Resolution(1_u64 << depth)) };
        bake_tree(&scene, &options, Watch::none()).unwrap_err().to_string()
    };
    let region = |x, depth| Detail::Regions(vec![Region { x, z: [0.0, 1.0], depth }]);
    assert!(refused(region([1.0, 0.0], 8), 6).contains("a region"));
    assert!(refused(region([0.0, f64::NAN], 8), 6).contains("a region"));
    assert!(refused(region([0.0, 1.0], 16), 6).contains("depth of 16"));
    assert!(refused(region([0.0, 1.0], 6), 6).contains("deeper than the rest"));
    assert!(refused(region([900.0, 901.0], 8), 6).contains("touch the scene's cube"));
    let rings = |radii| Detail::Rings { center_xz: [0.0; 2], radii };
    assert!(refused(rings(vec![2.0, 1.0]), 6).contains("the rings"));
    assert!(refused(rings((1..9).map(f64::from).collect()), 6).contains("the rings"));
    assert!(refused(rings(vec![f64::NAN]), 6).contains("the rings"));
    assert!(refused(rings(vec![-1.0, 1.0]), 6).contains("the rings"));
    assert!(refused(Detail::Rings { center_xz: [900.0; 2], radii: vec![1.0] }, 6).contains("the rings"));
}

/// Whether a point is within `voxels` of a region's border, in voxels of the side that has the larger ones.
fn is_near_a_seam(baked: &BakedTree, p: [f64; 3], voxels: f64) -> bool {
    baked.regions.list.iter().any(|r| {
        let coarse = baked.space.voxel_size * f64::from(1_u32 << (baked.space.depth + 1 - r.depth)) * voxels;
        let [dx, dz] = [(p[0], r.x), (p[2], r.z)].map(|(c, [low, high])| {
            // Distance to the range if outside, or minus the distance to its nearer end if inside.
            (low - c).max(c - high)
        });
        dx.max(dz).abs() < coarse
    })
}

#[test]
fn tree_regions_side_by_side_have_no_coarse_seam() {
    let scene = generate(GeneratedKind::Primitives, 1);
    // An L of two boxes, and a deeper box over their common corner.
    let region = |x, z, depth| Region { x, z, depth };
    let list = vec![
        region([-8.0, 1.0], [-8.0, 8.0], 9),
        region([1.0, 8.0], [-8.0, 0.0], 9),
        region([0.0, 2.0], [-2.0, 2.0], 10),
    ];
    let baked = bake(&scene, 6, Detail::Regions(list));
    let query = query(&baked, 5);
    let size =
        |x: f64, z: f64| query.voxel_size_at([x, 2.0, z], Some([0.0, 1.0, 0.0])) / baked.space.voxel_size;
    // Along the seam between the two boxes, away from the deeper one.
    assert_eq!([0.9, 0.99, 1.0, 1.01, 1.1].map(|x| size(x, -6.0)), [2.0; 5]);
    // Across the border of the deeper one: never coarser than the boxes.
    assert!((0..100).all(|i| size(0.5 + 0.02 * f64::from(i), -1.0) <= 2.0));
    assert_eq!(size(1.5, -1.0), 1.0);
    // Outside the L it is coarse, even just outside its inner corner.
    assert_eq!(size(6.0, 6.0), 16.0);
    assert_eq!(size(2.3, 2.3), 16.0);
}

/// Every cube that the pyramid decides has cells with the same answer: with regions, given bounds, and
/// several suns.
#[test]
#[ignore = "slow: takes over eight seconds"]
fn tree_pruned_and_exhaustive_builds_agree_everywhere() {
    let regions = Detail::Regions(vec![
        Region { x: [-3.3, 4.1], z: [-2.2, 5.9], depth: 8 },
        Region { x: [2.0, 9.7], z: [3.0, 8.3], depth: 7 },
    ]);
    let rings = Detail::Rings { center_xz: [1.0, -1.0], radii: vec![2.0, 5.0] };
    let bounds = adumbra::Bounds { min: [-4.0, -0.5, -3.0], max: [5.0, 3.0, 6.0] };
    for kind in [GeneratedKind::Primitives, GeneratedKind::Landscape] {
        let scene = generate(kind, 2);
        for towards in [SUN, [0.0, 1.0, 0.0], [-0.9, 0.12, 0.4]] {
            for (detail, bounds) in [
                (Detail::Uniform, Some(bounds)),
                (regions.clone(), None),
                (regions.clone(), Some(bounds)),
                (rings.clone(), None),
            ] {
                let sun = Sun::from_direction(towards).unwrap();
                let options =
                    TreeOptions { detail, bounds, ..TreeOptions::new(sun, Size::Resolution(1 << 6)) };
                let build = |prune| {
                    let options = TreeOptions { prune, ..options.clone() };
                    bake_tree(&scene, &options, Watch::none()).unwrap().tree
                };
                assert!(build(true) == build(false), "{kind:?} {towards:?} {:?} {bounds:?}", options.detail);
            }
        }
    }
}

#[test]
fn small_tree_regions_have_no_seams() {
    have_no_seams(9, &[3], 200_000, 500.0);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn tree_regions_have_no_seams() {
    have_no_seams(11, &[1, 3, 5], 1_500_000, 10_000.0);
}

/// Verifies trees with regions near their seams.
fn have_no_seams(depth: u32, kernel_sides: &[u32], samples: u64, least: f64) {
    let scene = generate(GeneratedKind::Landscape, 1);
    let rings = Detail::Rings { center_xz: [3.0, -5.0], radii: vec![20.0, 45.0] };
    let baked = bake(&scene, depth, rings);
    let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: false });
    let solids = Solids::of(&scene);
    let sampler = Sampler::Surface(SurfaceSampler::new(&scene, &solids, sun().towards(), false));
    for &kernel_side in kernel_sides {
        let near = Replaced {
            answers: TreeAnswers::new(&baked.settings, sun(), query(&baked, kernel_side)),
            visibility: Answers::visibility,
            covers: |_: &TreeAnswers<'_, VoxelTree>, p| is_near_a_seam(&baked, p, 6.0),
        };
        let v = Verifier::new(&near, &tracer, &solids).run(&sampler, &VerifyOptions { samples, seed: 5 });
        println!("{kernel_side}: {v:?}");
        assert!(v.interior_share * v.samples as f64 > least, "{v:?}");
        assert!(v.interior_agreement >= 0.999, "kernel {kernel_side}: {v:?}");
    }
}
