//! The packed layout against the plain one: equal answers, there and back, broken ones refused.

use proptest::prelude::*;

use super::node::{Cube, Inner, Target};
use super::*;
use crate::dag::store::{NodeState, NodeStore, mix};
use crate::dag::{Dag, GraphPlace, LIT};

type Heights<'a> = dyn Fn(u32, u32) -> u32 + 'a;

/// The graph of columns that are lit below a height.
fn graph(size: [u32; 3], root_level: u32, height: &Heights<'_>) -> Dag {
    let mut store = NodeStore::default();
    let top_dims = Dag::top_dims_covering(size, root_level);
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
    if level == SLAB_NODE_LEVEL {
        let slabs = std::array::from_fn(|k| {
            let z = at[2] + k as u32;
            let lit = |bit: u32| z < height(at[0] + bit % 8, at[1] + bit / 8);
            let mask = (0..64).fold(0, |mask, bit| mask | u64::from(lit(bit)) << bit);
            store.slab(mask)
        });
        return store.cube(&slabs);
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
                assert_eq!(packed.slab(i, j, k), dag.slab(i, j, k), "{i} {j} {k}");
            }
        }
    }
}

#[test]
fn packed_worked_values() {
    // The module's first example.
    let inner = Inner {
        codes: 0x8c4,
        targets: [
            Target::Follows,
            Target::Pool(2),
            Target::Pool(2),
            Target::Near(5),
            Target::Follows,
            Target::Follows,
            Target::Follows,
            Target::Follows,
        ],
    };
    let mut units = Vec::new();
    inner.write(4, &mut units);
    assert_eq!(units, [0x08c4, 0x0402, 0x0402, 0x0005]);
    assert_eq!(Inner::read(&units, 4), Ok(inner));

    // Eight pointers with a slot each: the eighth is not taken for the one without.
    let eight = Inner { codes: 0x6db, targets: std::array::from_fn(|p| Target::Pool(p as u32)) };
    let mut units = Vec::new();
    eight.write(4, &mut units);
    assert_eq!(units, [0x76db, 0x400, 0x401, 0x402, 0x403, 0x404, 0x405, 0x406, 0x407]);
    assert_eq!(Inner::read(&units, 4), Ok(eight));
    let packed = PackedDag { top: vec![0; POOL_WORDS], units, ..PackedDag::default() };
    for c in 0..8 {
        assert!(
            matches!(packed.child(0, 4, c >> 2 << 3, (c >> 1 & 1) << 3, (c & 1) << 3), Step::Into(p) if p == c)
        );
    }

    // The second, and a wide pointer of each width.
    let mask = 0xff0f_0f0f_0f0f_0f0f;
    let cube = Cube::of_slabs(&[u64::MAX, u64::MAX, mask, mask, mask, 0, 0, 0]).unwrap();
    let mut units = Vec::new();
    cube.write(&mut units);
    assert_eq!(units, [0x0324, 0x0f0f, 0x0f0f, 0x0f0f, 0xff0f]);

    let far = Inner { codes: 4, targets: [Target::Pool(0xabcde); 8] };
    for (high_bits, expected) in [
        (4, &[0xf004, 0x0a01, 0xbcde][..]),
        (8, &[0xf004, 0x0a01, 0xbcde][..]),
        (16, &[0xf004, 0x0001, 0x000a, 0xbcde][..]),
    ] {
        let mut units = Vec::new();
        far.write(high_bits, &mut units);
        assert_eq!(units, expected, "{high_bits}");
        assert_eq!(Inner::read(&units, high_bits).unwrap().pointers(), far.pointers());
        units[1] |= 0x8000;
        assert!(Inner::read(&units, high_bits).is_err() || high_bits == 8);
    }
}

#[test]
fn packed_wide_slots_reach_as_far_as_the_pool_asks() {
    // Eight pointers, wide ones between others, in pools of up to 2^20, 2^24 and more units.
    for (pool_units, last) in [(1 << 20, 0xf_fffe), (1 << 24, 0xff_fffe), (1 << 30, 0x3fff_fffe)] {
        let targets: [u32; 8] = std::array::from_fn(|p| if p % 3 == 0 { p as u32 } else { last - p as u32 });
        let inner = Inner { codes: 0x6db, targets: targets.map(Target::Pool) };
        let high_bits = super::node::high_bits(pool_units);
        let mut units = Vec::new();
        inner.write(high_bits, &mut units);
        assert_eq!(Inner::read(&units, high_bits), Ok(inner));
        let mut top = vec![0; POOL_WORDS];
        top[1] = pool_units;
        let packed = PackedDag { top, units, ..PackedDag::default() };
        for (c, &target) in (0_u32..).zip(&targets) {
            let step = packed.child(0, 4, c >> 2 << 3, (c >> 1 & 1) << 3, (c & 1) << 3);
            assert!(matches!(step, Step::Into(unit) if unit == target), "{pool_units} {c}");
        }
    }
}

#[test]
fn packed_planes_hold_what_masks_do() {
    // Eight masks, each a column less lit than the one before, in four planes; two in two, shared in none.
    for count in 1..=8_u32 {
        let slabs: [u64; 8] = std::array::from_fn(|k| u64::MAX << (8 * (k as u32).min(count - 1) + 3));
        let cube = Cube::of_slabs(&slabs).unwrap();
        assert_eq!((cube.mask_count() as u32, cube.in_planes()), (count, count > 2));
        let mut units = Vec::new();
        cube.write(&mut units);
        assert_eq!(units.len() as u32, cube.units());
        let (read, length) = Cube::read(&units, &[]).unwrap();
        assert_eq!((read.slabs(), length), (slabs, units.len() as u32));
        let packed = PackedDag { units, ..PackedDag::default() };
        for k in 0..8 {
            assert_eq!(packed.slab_of_cube(0, k), slabs[k as usize], "{count} {k}");
        }
    }
}

#[test]
fn packed_pools_beyond_narrow_slots_answer_alike() {
    // 20,000 blocks that lie about three times each: their pool has more units than narrow slots reach.
    let block = |x: u32, y: u32| mix(u64::from(x / 8) << 32 | u64::from(y / 8)) % 20_000;
    let height = |x: u32, y: u32| (mix(block(x, y) << 6 | u64::from(y % 8 * 8 + x % 8)) % 3) as u32 + 2;
    let dag = graph([2048, 2048, 8], 8, &height);
    let packed = PackedDag::of_dag(&dag).unwrap();
    assert!(packed.top[1] > 0x1_0000, "{}", packed.top[1]);
    for threads in [1, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert!(pool.install(|| PackedDag::of_dag(&dag)).unwrap() == packed, "{threads} threads");
    }
    assert_same(&dag, &packed);
    assert!(packed.to_dag().unwrap() == dag);
}

#[test]
fn packed_nodes_of_several_levels_answer_alike() {
    // Steps of 8 and of 16 voxels without a slab below: one plain node at two levels, a packed one each.
    let height = |x: u32, _: u32| if x < 32 { 16 * (x / 16) } else { 8 * (x / 8 % 2) };
    let dag = graph([64, 32, 64], 5, &height);
    let packed = PackedDag::of_dag(&dag).unwrap();
    assert_same(&dag, &packed);
    assert!(packed.to_dag().unwrap() == dag);
}

#[test]
fn packed_refuses_what_is_lit_behind_shadow() {
    let mut lit_below = graph([8, 8, 16], 3, &|_, _| 8);
    assert_eq!(lit_below.top.len(), 2);
    lit_below.top.swap(0, 1);
    assert_eq!(
        PackedDag::of_dag(&lit_below),
        Err(PackError::NotMonotone { place: GraphPlace::Top { index: 1 }, level: 3 })
    );
    let mut holes = graph([8, 8, 8], 3, &|x, _| x);
    let slabs = holes.slabs.len();
    holes.slabs[slabs - 1] = 1;
    let fault = PackError::NotMonotone { place: GraphPlace::Node { word: 0 }, level: 3 };
    assert_eq!(PackedDag::of_dag(&holes), Err(fault));
}

#[test]
fn packed_uniform_grids_have_no_units() {
    for (height, z0, end) in [(0, 0, 0), (100, 2, 0)] {
        let dag = graph([16, 8, 16], 3, &|_, _| height);
        assert_eq!(dag.top[0] == LIT, height > 0);
        let packed = PackedDag::of_dag(&dag).unwrap();
        assert_eq!(&packed.top[POOL_WORDS..], [0, z0, 0, z0, end]);
        assert!(packed.units.is_empty() && packed.slabs.is_empty());
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
fn packed_trails_lead_where_ways_from_the_top_do() {
    let dag = graph([70, 60, 66], 4, &hills(7, 12, 3));
    let packed = PackedDag::of_dag(&dag).unwrap();
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
        let expected = dag.slab(i, j, k);
        assert_eq!(dag.slab_along(&mut trails[0], i, j, k), expected, "{voxel:?}");
        assert_eq!(packed.slab_along(&mut trails[1], i, j, k), expected, "{voxel:?}");
        for (layout, trail) in [&dag as &dyn Slabs, &packed].into_iter().zip(&mut trails) {
            let mut slabs = [0; 8];
            let known = layout.fill_along(trail, voxel, &mut slabs);
            assert!(known >> (k & 7) & 1 == 1);
            for z in (0..8).filter(|z| known >> z & 1 == 1) {
                assert_eq!(slabs[z as usize], dag.slab(i, j, k & !7 | z), "{voxel:?} {known:b} {z}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn packed_graphs_answer_as_plain_ones(
        size in [1_u32..70, 1_u32..70, 1_u32..70], root_level in 3_u32..8, seed: u64, roughness in 1_u32..20, flat in 1_u32..9,
    ) {
        let dag = graph(size, root_level, &hills(seed, roughness, flat));
        let packed = PackedDag::of_dag(&dag).unwrap();
        assert_same(&dag, &packed);
        prop_assert!(packed.to_dag().unwrap() == dag);
        let composition = packed.composition().unwrap();
        let bytes = composition.top_bytes + composition.header_bytes + composition.pointer_bytes + composition.slab_bytes;
        let units = packed.top[POOL_WORDS - 1] as usize;
        prop_assert_eq!(bytes as usize, packed.top.len() * 4 + units * 2 + packed.slabs.len() * 8);
    }

    #[test]
    fn packed_graphs_that_are_broken_are_refused_or_answer(
        seed: u64, breaks in prop::collection::vec((any::<u16>(), any::<u32>(), 0..3_u8), 1..4),
    ) {
        let size = [40, 24, 50];
        let mut packed = PackedDag::of_dag(&graph(size, 4, &hills(seed, 9, 1))).unwrap();
        for (at, value, part) in breaks {
            let at = usize::from(at);
            match part {
                0 => { let n = packed.top.len(); packed.top[at % n] ^= value & 0xff; }
                1 => { let n = packed.units.len(); packed.units[at % n] ^= 1 << (value % 16); }
                _ => { let n = packed.slabs.len(); if n > 0 { packed.slabs[at % n] ^= 1 << (value % 64); } }
            }
        }
        if packed.validate().is_ok() {
            for k in 0..64 {
                for j in (0..32).step_by(8) {
                    for i in (0..48).step_by(8) {
                        packed.slab(i, j, k);
                    }
                }
            }
            let plain = packed.to_dag().unwrap();
            plain.validate().unwrap();
            assert_same(&plain, &packed);
        }
    }
}
