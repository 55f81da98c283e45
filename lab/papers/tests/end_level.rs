//! Tests the block in which a look-up ends: the block is all lit or all shadowed, and no larger block is.

use adumbra::layout::depths::DepthTree;
use adumbra::query::{FixedReceiver, Receiver};
use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size, Watch};
use adumbra_papers::dag::build::{DagOptions, bake};
use adumbra_papers::dag::{DagFile, DagLayout, DagQuery, LeafMasks};
use adumbra_papers::tree::query::{TreeQuery, Weights};
use adumbra_papers::tree::{Detail, TreeOptions, bake_tree};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_testing::end_level;

fn sun() -> Sun {
    Sun::from_direction([0.5, 0.8, 0.35]).unwrap()
}

fn scene() -> Scene {
    generate(GeneratedKind::City, 7)
}

fn options() -> BakeOptions {
    BakeOptions::new(sun(), Size::Resolution(512))
}

fn graph(layout: DagLayout) -> DagFile {
    bake(&scene(), &DagOptions { bake: options(), layout }, Watch::none()).unwrap().file
}

fn quadtree() -> ShadowFile {
    Bake::with_options(&scene(), &options()).in_memory().unwrap()
}

/// Voxels of a grid, half of them near the switch depths of their columns.
fn voxels(depths: &DepthTree, count: usize) -> Vec<[u32; 3]> {
    let mut random = Random::for_batch(3, 0);
    let size = depths.size();
    let mut below = |n: u32| (random.unit() * f64::from(n)) as u32;
    (0..count)
        .map(|at| {
            let [i, j] = [below(size[0]), below(size[1])];
            let value = depths.value(i, j).min(size[2] - 1);
            [i, j, if at % 2 == 0 { value.saturating_sub(below(3)) } else { below(size[2]) }]
        })
        .collect()
}

/// Whether all voxels of the block of this level around a voxel have its visibility. Voxels outside the grid
/// are not checked.
fn is_uniform(leaf_masks: &dyn LeafMasks, voxel: [u32; 3], level: u32) -> bool {
    let size = leaf_masks.size();
    let range = |a: usize| {
        let from = voxel[a] >> level << level;
        from..(from + (1 << level)).min(size[a])
    };
    let leaf_mask = if leaf_masks.voxel(voxel[0], voxel[1], voxel[2]) { u64::MAX } else { 0 };
    range(2).all(|k| {
        range(1).step_by(8).all(|j| range(0).step_by(8).all(|i| leaf_masks.look_up(i, j, k) == leaf_mask))
    })
}

#[test]
fn graph_look_ups_end_in_largest_uniform_block() {
    let [file, packed] = [DagLayout::Plain, DagLayout::Packed].map(graph);
    let columns = &*quadtree().tree;
    let (plain, packed) = (file.body.leaf_masks(), packed.body.leaf_masks());
    let root_level = file.body.root_level();
    let mut seen = [0; 14];
    for voxel @ [i, j, k] in voxels(columns, 4000) {
        let level = plain.end_level(i, j, k);
        assert_eq!(level, packed.end_level(i, j, k), "{voxel:?}");
        seen[level as usize] += 1;
        let leaf_mask = plain.look_up(i, j, k);
        match level {
            0 => assert!(leaf_mask != 0 && leaf_mask != u64::MAX, "{voxel:?}"),
            3 => assert!(leaf_mask == 0 || leaf_mask == u64::MAX, "{voxel:?}"),
            _ => assert!(is_uniform(plain, voxel, level), "{voxel:?}: {level}"),
        }
        // At the border of the grid a larger block may contain anything outside it.
        let is_whole = (0..3).all(|a| ((voxel[a] >> (level + 1)) + 1) << (level + 1) <= plain.size()[a]);
        if level >= 3 && level < root_level && is_whole {
            assert!(!is_uniform(plain, voxel, level + 1), "{voxel:?}: {level}");
        }
    }
    assert!(seen[1] + seen[2] == 0 && [0, 3, 4].iter().all(|l| seen[*l] > 50), "{seen:?}");
}

#[test]
fn depth_look_ups_end_in_columns_with_equal_depth() {
    let columns = &*quadtree().tree;
    let mut seen = [0; 14];
    for voxel @ [i, j, k] in voxels(columns, 2000) {
        let level = columns.end_level(i, j, k);
        seen[level as usize] += 1;
        let block = |level: u32| {
            let range = |c: u32, n: u32| (c >> level << level)..((c >> level << level) + (1 << level)).min(n);
            let value = columns.value(i, j);
            range(j, columns.size()[1])
                .all(|y| range(i, columns.size()[0]).all(|x| columns.value(x, y) == value))
        };
        assert!(level == 0 || block(level), "{voxel:?}: {level}");
        assert!(level > 0 || !block(3), "{voxel:?}");
    }
    assert!(seen[0] > 50 && seen[3] > 50, "{seen:?}");
}

#[test]
fn look_ups_outside_the_grid_have_no_end_level() {
    let (graph, quadtree) = (graph(DagLayout::Packed), quadtree());
    let query = DagQuery::new(&graph.grid, graph.body.leaf_masks(), graph.settings.bias, Filter::Box5);
    let [nx, ny, nz] = graph.grid.size.map(f64::from);
    let levels = |p_grid| {
        let r = FixedReceiver::new(&Receiver { p_grid, gradient: [0.0; 2] }, graph.grid.size);
        [query.end_level(&r), end_level(&quadtree.tree, &r)]
    };
    for p in [[-0.5, 4.0, 4.0], [4.0, ny + 0.5, 4.0], [4.0, 4.0, -0.5], [nx + 1e9, 0.0, 0.0]] {
        assert_eq!(levels(p), [None; 2], "{p:?}");
    }
    // A look-up behind the grid uses the last layer.
    assert_eq!(levels([9.5, 9.5, nz + 100.0]), levels([9.5, 9.5, nz - 0.5]));
    assert!(levels([9.5, 9.5, 0.5]).iter().all(Option::is_some));
}

#[test]
fn small_tree_look_ups_end_in_largest_uniform_cube() {
    end_in_the_largest_cube(Detail::Uniform, 64);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn tree_look_ups_end_in_largest_uniform_cube() {
    end_in_the_largest_cube(Detail::Uniform, 128);
    end_in_the_largest_cube(Detail::Rings { center_xz: [0.0, 0.0], radii: vec![20.0, 60.0] }, 128);
}

fn end_in_the_largest_cube(detail: Detail, resolution: u64) {
    let options = TreeOptions { detail, ..TreeOptions::new(sun(), Size::Resolution(resolution)) };
    let t = bake_tree(&scene(), &options, Watch::none()).unwrap();
    let bias = t.settings.bias;
    let query = TreeQuery::new(&t.space, &t.regions, &sun(), &t.tree, bias, 3, Weights::Mean).unwrap();
    let side = t.space.side_voxels();
    let mut random = Random::for_batch(5, 0);
    let mut seen = [0; 14];
    for _ in 0..4000 {
        let p_world =
            std::array::from_fn(|a| t.space.p_min[a] + random.unit() * f64::from(side) * t.space.voxel_size);
        // If the point is lifted above the cube, it is lit regardless of the cube's contents.
        let Some(receiver) = query.receiver(p_world, Some([0.0, 1.0, 0.0])) else { continue };
        let voxel = query.voxel_at(p_world, Some([0.0, 1.0, 0.0])).unwrap();
        let level = query.end_level(&receiver);
        seen[level as usize] += 1;
        let uniform = |level: u32| {
            let from = voxel.map(|c| c >> level << level);
            let lit = t.tree.voxel(voxel);
            (0..1 << (3 * level)).all(|i: u32| {
                let at = [i >> (2 * level), i >> level, i].map(|c| c & ((1 << level) - 1));
                t.tree.voxel(std::array::from_fn(|a| from[a] + at[a])) == lit
            })
        };
        assert!(uniform(level) && (level >= t.space.depth || !uniform(level + 1)), "{voxel:?}: {level}");
    }
    assert!(seen.iter().filter(|n| **n > 20).count() > 3, "{seen:?}");
}
