//! Packed graphs on the GPU against their CPU twin: equal counts for every fixed-point receiver and every
//! width of pointers.

use std::collections::HashSet;

use adumbra::query::{FIXED_ONE, FixedReceiver, MAX_GRADIENT};
use adumbra::{Bias, Filter, Frame, LightGrid, Sun};
use adumbra_papers::dag::build::pack;
use adumbra_papers::dag::build::store::{NodeState, NodeStore};
use adumbra_papers::dag::packed::{NEAR_UNITS, POOL_WORDS, PackedDag};
use adumbra_papers::dag::plain::Dag;
use adumbra_papers::dag::{DagBody, DagFile, DagQuery, LeafMasks};
use adumbra_papers::techniques::{Graph, GraphSettings};
use adumbra_render::Gpu;
use adumbra_scene::random::Random;
use adumbra_testing::settings_for;

use crate::kit;

const COUNT: usize = 100_000;

/// A graph of cubes of eight voxels per side: 20,000 different ones, each used about three times, so that
/// their pool has wide slots.
fn many_cubes() -> Dag {
    let store = NodeStore::default();
    let hash =
        |v: u64| v.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mut nodes: Vec<NodeState> = (0..1_u64 << 16)
        .map(|place| {
            let cube = hash(place + 1) % 20_000;
            let (once, twice) = (hash(cube ^ 1 << 40), hash(cube ^ 1 << 50));
            let leaf_masks = [u64::MAX, once | twice, once, once & twice, 0, 0, 0, 0];
            store.cube(&leaf_masks.map(|mask| store.leaf_mask(mask)))
        })
        .collect();
    // Each inner node has four children side by side. The four beyond them are shadowed.
    for _ in 4..=8 {
        let row = nodes.len().isqrt();
        nodes = (0..nodes.len() / 4)
            .map(|i| {
                let (x, y) = (2 * (i % (row / 2)), 2 * (i / (row / 2)));
                store.inner(&std::array::from_fn(|c| match c & 1 {
                    0 => nodes[(y + (c >> 1 & 1)) * row + x + (c >> 2)],
                    _ => NodeState::Shadowed,
                }))
            })
            .collect();
    }
    store.finish([2048, 2048, 8], 8, [8, 8, 1], &nodes)
}

#[test]
#[ignore = "slow: draws on the GPU and counts on the CPU"]
fn packed_graph_with_wide_slots_matches_cpu_tap_counts() {
    let dag = many_cubes();
    let packed = pack(&dag).unwrap();
    assert!(packed.top[1] > (1 << 16) - NEAR_UNITS, "{}", packed.top[1]);
    let gpu = kit::gpu();
    let grid = LightGrid { size: dag.size, ..unit_grid() };
    let mut random = Random::for_batch(5, 0);
    let receivers: Vec<_> = (0..COUNT)
        .map(|at| FixedReceiver {
            p_fixed: dag.size.map(|n| (random.unit() * f64::from(n) * f64::from(FIXED_ONE)) as i64),
            gradient: match at % 8 {
                // Gradients up to the maximum; rows without a gradient; gradients in whole steps; others.
                0 => [0; 2].map(|_| (random.unit() * f64::from(2 * MAX_GRADIENT + 1)) as i32 - MAX_GRADIENT),
                1 => [0, (random.unit() * 600.0) as i32 - 300],
                2 => [0; 2].map(|_| 256 * ((random.unit() * 5.0) as i32 - 2)),
                _ => [0; 2].map(|_| (random.unit() * 600.0) as i32 - 300),
            },
        })
        .collect();
    for filter in Filter::ALL {
        let query = DagQuery::new(&grid, &packed, Bias::default(), filter);
        let plain = DagQuery::new(&grid, &dag, Bias::default(), filter);
        let graph = uploaded(&gpu, grid, &packed, filter);
        let mut partly = 0;
        for (r, found) in receivers.iter().zip(graph.lit_taps(&gpu, &receivers).unwrap()) {
            assert_eq!([found, found], [query.lit_taps(r), plain.lit_taps(r)], "{filter:?}: {r:?}");
            partly += usize::from(found > 0 && found < filter.width().pow(2));
        }
        assert!(filter == Filter::Nearest || partly * 4 > COUNT, "{partly} partly lit");
    }
}

fn uploaded(gpu: &Gpu, grid: LightGrid, packed: &PackedDag, filter: Filter) -> Graph {
    let body = DagBody::Packed(packed.clone());
    let file = DagFile { grid, settings: settings_for(&grid), body };
    let settings = GraphSettings { filter, bias: Bias::default() };
    Graph::new(gpu, "voxel-dag".to_owned(), &file, settings).unwrap()
}

/// A grid of unit voxels, sixteen per side, along the world axes.
fn unit_grid() -> LightGrid {
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    LightGrid::new(sun, Frame::Light, 1.0, [0.0; 3], [16; 3])
}

/// A graph of sixteen voxels per side made of eight cubes, each with one leaf mask. The pool has `pool_units`
/// units, and pointers of every kind lead into it and past it.
fn eight_cubes(pool_units: u32, high_bits: u32) -> PackedDag {
    let mut units = vec![0; pool_units as usize];
    let bits = |p: u32| (0x9e37_79b9_u32.wrapping_mul(p + 1) >> 11) as u16;
    let cube = |units: &mut [u16], p: u32| {
        units[0] = 0x0201;
        // A voxel lit in the farther cube is also lit in the nearer cube, because columns switch once.
        units[1..5].fill(if p & 1 == 0 { bits(p) | bits(p + 1) } else { bits(p) });
    };
    // The cube of pointer 1 follows the slots, and pointer 3 is near. Four pointers are wide, the other two
    // are narrow.
    let wide = [0, 2, 5, 7];
    let mut string = vec![0_u16; (high_bits.max(8) + 4 * high_bits).div_ceil(16) as usize];
    let mut place = high_bits.max(8);
    let mut slots = Vec::new();
    let mut inside = [0; 10];
    for p in 0..8 {
        match p {
            1 => cube(&mut inside, p),
            3 => {
                cube(&mut inside[5..], p);
                slots.push(5);
            }
            _ => {
                let is_wide = wide.contains(&p);
                let target = if is_wide { pool_units - 5 * (p + 1) } else { 7 * p };
                cube(&mut units[target as usize..], p);
                if is_wide {
                    string[0] |= 1 << p;
                    string[(place >> 4) as usize] |= (target >> 16 << (place & 15)) as u16;
                    place += high_bits;
                }
                slots.push(if is_wide { target } else { target + NEAR_UNITS } as u16);
            }
        }
    }
    units.push(0x96db);
    units.extend(string.into_iter().chain(slots).chain(inside));
    units.resize(units.len().next_multiple_of(2), 0);
    let mut top = vec![units.len() as u32; POOL_WORDS];
    top[..2].copy_from_slice(&[0, pool_units]);
    top.extend([0, 0, 1, 0]);
    PackedDag { size: [16; 3], root_level: 4, top_dims: [1; 3], top, units, leaf_masks: Vec::new() }
}

#[test]
fn packed_graph_follows_wide_slots_of_every_width() {
    let gpu = kit::gpu();
    let grid = unit_grid();
    let centre = |c: i64| c * i64::from(FIXED_ONE) + i64::from(FIXED_ONE / 2);
    let gradients = [[0, 0], [256, -100]];
    let receivers: Vec<_> = (0..4096)
        .flat_map(|i| {
            let p_fixed = [i & 15, i >> 4 & 15, i >> 8].map(centre);
            gradients.map(|gradient| FixedReceiver { p_fixed, gradient })
        })
        .collect();
    for (pool_units, high_bits) in [(1 << 20, 4), ((1 << 20) + 2, 8), (1 << 24, 8), ((1 << 24) + 2, 16)] {
        let packed = eight_cubes(pool_units, high_bits);
        for filter in [Filter::Nearest, Filter::Box9] {
            let query = DagQuery::new(&grid, &packed, Bias::default(), filter);
            let expected: Vec<_> = receivers.iter().map(|r| query.lit_taps(r)).collect();
            let graph = uploaded(&gpu, grid, &packed, filter);
            assert!(graph.lit_taps(&gpu, &receivers).unwrap() == expected, "{pool_units} {filter:?}");
            assert!(expected.contains(&0) || filter != Filter::Nearest);
        }
        let masks: HashSet<u64> =
            (0..8).map(|c| packed.look_up(c >> 2 << 3, c >> 1 << 3 & 8, c << 3 & 8)).collect();
        assert_eq!(masks.len(), 8, "{pool_units}");
    }
}
