//! Where look-ups end: the block that is said to answer is all lit or all shadowed, and no larger one is.

use std::sync::atomic::AtomicBool;

use adumbra::bake::{Options, Size, bake};
use adumbra::dag::Slabs;
use adumbra::format::{Layout, ShadowFile};
use adumbra::hierarchy::Hierarchy;
use adumbra::light::Sun;
use adumbra::query::{FixedReceiver, Query, Receiver, TreeQuery, Weights};
use adumbra::scene::{GeneratedKind, Scene, generate};
use adumbra::tree::{Detail, TreeOptions, bake_tree};
use adumbra::verify::Random;

fn sun() -> Sun {
    Sun::from_direction([0.5, 0.8, 0.35]).unwrap()
}

fn scene() -> Scene {
    generate(GeneratedKind::City, 7)
}

fn file() -> ShadowFile {
    let options = Options::new(sun(), Size::Resolution(512));
    let baked = bake(&scene(), &options, &|_| {}, &AtomicBool::new(false)).unwrap();
    ShadowFile::plain(baked.grid, baked.settings, baked.dag)
}

fn in_layout(file: &ShadowFile, layout: Layout) -> ShadowFile {
    ShadowFile::of_dag(file.grid, file.settings, file.graph().unwrap().into_owned(), layout).unwrap()
}

/// Voxels of a grid, half of them near where columns switch.
fn voxels(hierarchy: &Hierarchy, count: usize) -> Vec<[u32; 3]> {
    let mut random = Random::new(3, 0);
    let size = hierarchy.size;
    let mut below = |n: u32| (random.unit() * f64::from(n)) as u32;
    (0..count)
        .map(|at| {
            let [i, j] = [below(size[0]), below(size[1])];
            let value = hierarchy.value(i, j).min(size[2] - 1);
            [i, j, if at % 2 == 0 { value.saturating_sub(below(3)) } else { below(size[2]) }]
        })
        .collect()
}

fn is_lit(slabs: &dyn Slabs, [i, j, k]: [u32; 3]) -> bool {
    slabs.slab(i, j, k) >> ((j & 7) * 8 + (i & 7)) & 1 == 1
}

/// Whether every voxel of the block of a level that holds this one has its visibility; as far as it lies in the grid.
fn is_uniform(slabs: &dyn Slabs, voxel: [u32; 3], level: u32) -> bool {
    let size = slabs.size();
    let range = |a: usize| {
        let from = voxel[a] >> level << level;
        from..(from + (1 << level)).min(size[a])
    };
    let lit = is_lit(slabs, voxel);
    let slab = if lit { u64::MAX } else { 0 };
    range(2).all(|k| range(1).step_by(8).all(|j| range(0).step_by(8).all(|i| slabs.slab(i, j, k) == slab)))
}

#[test]
fn look_ups_in_graphs_end_in_the_largest_block_that_is_uniform() {
    let file = file();
    let (packed, hierarchy) = (in_layout(&file, Layout::Packed), in_layout(&file, Layout::Hierarchy));
    let adumbra::format::LightBody::Hierarchy(columns) = &hierarchy.body else { panic!("no hierarchy") };
    let (plain, packed) = (file.slabs(), packed.slabs());
    let root_level = file.graph().unwrap().root_level;
    let mut seen = [0; 14];
    for voxel @ [i, j, k] in voxels(columns, 4000) {
        let level = plain.end_level(i, j, k);
        assert_eq!(level, packed.end_level(i, j, k), "{voxel:?}");
        seen[level as usize] += 1;
        let slab = plain.slab(i, j, k);
        match level {
            0 => assert!(slab != 0 && slab != u64::MAX, "{voxel:?}"),
            3 => assert!(slab == 0 || slab == u64::MAX, "{voxel:?}"),
            _ => assert!(is_uniform(plain, voxel, level), "{voxel:?}: {level}"),
        }
        // Beside the grid a larger block may hold anything.
        let is_whole = (0..3).all(|a| ((voxel[a] >> (level + 1)) + 1) << (level + 1) <= plain.size()[a]);
        if level >= 3 && level < root_level && is_whole {
            assert!(!is_uniform(plain, voxel, level + 1), "{voxel:?}: {level}");
        }
    }
    assert!(seen[1] + seen[2] == 0 && [0, 3, 4].iter().all(|l| seen[*l] > 50), "{seen:?}");
}

#[test]
fn look_ups_in_hierarchies_end_in_columns_that_switch_together() {
    let hierarchy = in_layout(&file(), Layout::Hierarchy);
    let adumbra::format::LightBody::Hierarchy(columns) = &hierarchy.body else { panic!("no hierarchy") };
    let mut seen = [0; 14];
    for voxel @ [i, j, k] in voxels(columns, 2000) {
        let level = columns.end_level(i, j, k);
        seen[level as usize] += 1;
        let block = |level: u32| {
            let range = |c: u32, n: u32| (c >> level << level)..((c >> level << level) + (1 << level)).min(n);
            let value = columns.value(i, j);
            range(j, columns.size[1]).all(|y| range(i, columns.size[0]).all(|x| columns.value(x, y) == value))
        };
        assert!(level == 0 || block(level), "{voxel:?}: {level}");
        assert!(level > 0 || !block(3), "{voxel:?}");
    }
    assert!(seen[0] > 50 && seen[3] > 50, "{seen:?}");
}

#[test]
fn look_ups_beside_a_file_end_nowhere() {
    let file = file();
    let query = Query::new(&file.grid, file.slabs(), file.settings.bias, 5).unwrap();
    let [nx, ny, nz] = file.grid.size.map(f64::from);
    let level = |p_grid| {
        query.end_level(&FixedReceiver::new(&Receiver { p_grid, gradient: [0.0; 2] }, file.grid.size))
    };
    for p in [[-0.5, 4.0, 4.0], [4.0, ny + 0.5, 4.0], [4.0, 4.0, -0.5], [nx + 1e9, 0.0, 0.0]] {
        assert_eq!(level(p), None, "{p:?}");
    }
    // Behind the grid its last layer answers.
    assert_eq!(level([9.5, 9.5, nz + 100.0]), level([9.5, 9.5, nz - 0.5]));
    assert!(level([9.5, 9.5, 0.5]).is_some());
}

#[test]
fn look_ups_in_trees_end_in_the_largest_cube_that_is_uniform() {
    let rings = Detail::Rings { center_xz: [0.0, 0.0], radii: vec![20.0, 60.0] };
    for detail in [Detail::Uniform, rings] {
        let options = TreeOptions { detail, ..TreeOptions::new(sun(), Size::Resolution(128)) };
        let t = bake_tree(&scene(), &options, &|_| {}, &AtomicBool::new(false)).unwrap();
        let bias = t.settings.bias;
        let query = TreeQuery::new(&t.space, &t.regions, &sun(), &t.tree, bias, 3, Weights::Mean).unwrap();
        let side = t.space.side_voxels();
        let mut random = Random::new(5, 0);
        let mut seen = [0; 14];
        for _ in 0..4000 {
            let p_world = std::array::from_fn(|a| {
                t.space.p_min[a] + random.unit() * f64::from(side) * t.space.voxel_size
            });
            // Lifted over the cube it is lit, whatever the cube holds.
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
}
