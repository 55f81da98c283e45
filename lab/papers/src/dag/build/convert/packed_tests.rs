//! The packed layout compared with the plain one: equal answers, round trips, broken graphs refused.

use crate::dag::roots::{LEAF_NODE_LEVEL, top_dims};
use adumbra_scene::random::mix;
use proptest::prelude::*;

use crate::dag::build::convert::unpack;
use crate::dag::build::pack;
use crate::dag::build::store::{NodeState, NodeStore};
use crate::dag::packed::{POOL_WORDS, PackedDag};
use crate::dag::plain::{Dag, GraphPlace, LIT};
use crate::dag::{LeafMasks, PackError, Trail};

type Heights<'a> = dyn Fn(u32, u32) -> u32 + 'a;

/// Builds the graph of columns that are lit below a height.
fn graph(size: [u32; 3], root_level: u32, height: &Heights<'_>) -> Dag {
    let mut store = NodeStore::default();
    let top_dims = top_dims(size, root_level);
    let mut top = Vec::new();
    for gz in 0..top_dims[2] {
        for gy in 0..top_dims[1] {
            for gx in 0..top_dims[0] {
                top.push(cube(&mut store, size, [gx, gy, gz].map(|g| g << root_level), root_level, height));
            }
        }
    }
    store.finish(size, root_level, top_dims, &top)
}

fn cube(store: &mut NodeStore, size: [u32; 3], at: [u32; 3], level: u32, height: &Heights<'_>) -> NodeState {
    if (0..2).any(|a| at[a] >= size[a]) {
        return NodeState::Lit;
    }
    if at[2] >= size[2] {
        return NodeState::Shadowed;
    }
    if level == LEAF_NODE_LEVEL {
        let leaf_masks = std::array::from_fn(|k| {
            let z = at[2] + k as u32;
            let lit = |bit: u32| z < height(at[0] + bit % 8, at[1] + bit / 8);
            let mask = (0..64).fold(0, |mask, bit| mask | u64::from(lit(bit)) << bit);
            store.leaf_mask(mask)
        });
        return store.cube(&leaf_masks);
    }
    let half = level - 1;
    let children = std::array::from_fn(|c| {
        let c = c as u32;
        let bits = [c >> 2, c >> 1 & 1, c & 1];
        cube(store, size, [0, 1, 2].map(|a| at[a] + (bits[a] << half)), half, height)
    });
    store.inner(&children)
}

fn assert_same(dag: &Dag, packed: &PackedDag) {
    packed.validate().unwrap();
    let extent = dag.top_dims.map(|n| n << dag.root_level);
    for k in 0..extent[2] {
        for j in (0..extent[1]).step_by(8) {
            for i in (0..extent[0]).step_by(8) {
                assert_eq!(packed.look_up(i, j, k), dag.look_up(i, j, k), "{i} {j} {k}");
            }
        }
    }
}

#[test]
fn packed_matches_plain_beyond_narrow_slots() {
    // 20,000 blocks that occur about three times each: their pool has more units than narrow slots can
    // address.
    let block = |x: u32, y: u32| mix(u64::from(x / 8) << 32 | u64::from(y / 8)) % 20_000;
    let height = |x: u32, y: u32| (mix(block(x, y) << 6 | u64::from(y % 8 * 8 + x % 8)) % 3) as u32 + 2;
    let dag = graph([2048, 2048, 8], 8, &height);
    let packed = pack(&dag).unwrap();
    assert!(packed.top[1] > 0x1_0000, "{}", packed.top[1]);
    for threads in [1, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert!(pool.install(|| pack(&dag)).unwrap() == packed, "{threads} threads");
    }
    assert_same(&dag, &packed);
    assert!(unpack(&packed).unwrap() == dag);
}

#[test]
fn packed_matches_plain_for_nodes_shared_by_levels() {
    // Steps of 8 and of 16 voxels without a leaf mask below: one plain node serves two levels, a packed node
    // only one.
    let height = |x: u32, _: u32| if x < 32 { 16 * (x / 16) } else { 8 * (x / 8 % 2) };
    let dag = graph([64, 32, 64], 5, &height);
    let packed = pack(&dag).unwrap();
    assert_same(&dag, &packed);
    assert!(unpack(&packed).unwrap() == dag);
}

#[test]
fn packed_rejects_columns_lit_behind_shadow() {
    let mut lit_below = graph([8, 8, 16], 3, &|_, _| 8);
    assert_eq!(lit_below.top.len(), 2);
    lit_below.top.swap(0, 1);
    assert_eq!(
        pack(&lit_below),
        Err(PackError::NotMonotone { place: GraphPlace::Top { index: 1 }, level: 3 })
    );
    let mut holes = graph([8, 8, 8], 3, &|x, _| x);
    let leaf_masks = holes.leaf_masks.len();
    holes.leaf_masks[leaf_masks - 1] = 1;
    let fault = PackError::NotMonotone { place: GraphPlace::Node { word: 0 }, level: 3 };
    assert_eq!(pack(&holes), Err(fault));
}

#[test]
fn packed_uniform_grids_have_no_units() {
    for (height, z0, end) in [(0, 0, 0), (100, 2, 0)] {
        let dag = graph([16, 8, 16], 3, &|_, _| height);
        assert_eq!(dag.top[0] == LIT, height > 0);
        let packed = pack(&dag).unwrap();
        assert_eq!(&packed.top[POOL_WORDS..], [0, z0, 0, z0, end]);
        assert!(packed.units.is_empty() && packed.leaf_masks.is_empty());
        assert_same(&dag, &packed);
    }
}

fn hills(seed: u64, roughness: u32, flat: u32) -> impl Fn(u32, u32) -> u32 {
    move |x, y| {
        let coarse = (mix(seed ^ u64::from(x / 16) << 20 ^ u64::from(y / 16)) % 40) as u32;
        let fine =
            (mix(seed ^ u64::from(x / flat) << 40 ^ u64::from(y / flat)) % u64::from(roughness)) as u32;
        coarse + fine
    }
}

#[test]
fn packed_look_ups_with_trail_match_look_ups_from_root() {
    let dag = graph([70, 60, 66], 4, &hills(7, 12, 3));
    let packed = pack(&dag).unwrap();
    let mut trails = [Trail::new(); 2];
    let mut state = 1;
    let mut voxel = [0_u32; 3];
    for step in 0..200_000_u64 {
        state = mix(state ^ step);
        let extent = [80, 64, 80];
        let a = (state % 3) as usize;
        voxel[a] = if state >> 8 & 31 == 0 {
            (state >> 16) as u32 % extent[a]
        } else {
            (voxel[a] + (state >> 16) as u32 % 3 + extent[a] - 1) % extent[a]
        };
        let [i, j, k] = voxel;
        let expected = dag.look_up(i, j, k);
        assert_eq!(dag.look_up_with(&mut trails[0], i, j, k), expected, "{voxel:?}");
        assert_eq!(packed.look_up_with(&mut trails[1], i, j, k), expected, "{voxel:?}");
        for (layout, trail) in [&dag as &dyn LeafMasks, &packed].into_iter().zip(&mut trails) {
            let mut leaf_masks = [0; 8];
            let known = layout.fill(trail, voxel, &mut leaf_masks);
            assert!(known >> (k & 7) & 1 == 1);
            for z in (0..8).filter(|z| known >> z & 1 == 1) {
                assert_eq!(leaf_masks[z as usize], dag.look_up(i, j, k & !7 | z), "{voxel:?} {known:b} {z}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn packed_matches_plain_for_random_graphs(
        size in [1_u32..70, 1_u32..70, 1_u32..70], root_level in 3_u32..8, seed: u64, roughness in 1_u32..20, flat in 1_u32..9,
    ) {
        let dag = graph(size, root_level, &hills(seed, roughness, flat));
        let packed = pack(&dag).unwrap();
        assert_same(&dag, &packed);
        prop_assert!(unpack(&packed).unwrap() == dag);
        let composition = packed.composition().unwrap();
        let bytes = composition.top_bytes + composition.header_bytes + composition.pointer_bytes + composition.leaf_mask_bytes;
        let units = packed.top[POOL_WORDS - 1] as usize;
        prop_assert_eq!(bytes as usize, packed.top.len() * 4 + units * 2 + packed.leaf_masks.len() * 8);
    }

    #[test]
    fn broken_packed_graphs_are_rejected_or_answer(
        seed: u64, breaks in prop::collection::vec((any::<u16>(), any::<u32>(), 0..3_u8), 1..4),
    ) {
        let size = [40, 24, 50];
        let mut packed = pack(&graph(size, 4, &hills(seed, 9, 1))).unwrap();
        for (at, value, part) in breaks {
            let at = usize::from(at);
            match part {
                0 => { let n = packed.top.len(); packed.top[at % n] ^= value & 0xff; }
                1 => { let n = packed.units.len(); packed.units[at % n] ^= 1 << (value % 16); }
                _ => { let n = packed.leaf_masks.len(); if n > 0 { packed.leaf_masks[at % n] ^= 1 << (value % 64); } }
            }
        }
        if packed.validate().is_ok() {
            for k in 0..64 {
                for j in (0..32).step_by(8) {
                    for i in (0..48).step_by(8) {
                        packed.look_up(i, j, k);
                    }
                }
            }
            let plain = unpack(&packed).unwrap();
            plain.validate().unwrap();
            assert_same(&plain, &packed);
        }
    }
}
