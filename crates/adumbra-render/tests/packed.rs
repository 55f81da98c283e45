//! Packed graphs on the GPU against their CPU twin: the same count for every receiver in fixed point, whatever the width of a pointer.

mod kit;
mod voxel_points;

use std::collections::HashSet;

use adumbra::dag::Dag;
use adumbra::dag::packed::{NEAR_UNITS, POOL_WORDS, PackedDag};
use adumbra::dag::store::{NodeState, NodeStore};
use adumbra::format::{Layout, LightBody};
use adumbra::light::{LightGrid, Sun};
use adumbra::query::{FILTER_WIDTHS, FIXED_ONE, FixedReceiver, MAX_GRADIENT, Query, TapLayers, receiver};
use adumbra::scene::{GeneratedKind, generate};
use adumbra::settings::Bias;
use adumbra::verify::Random;
use adumbra_render::voxel::Voxel;
use adumbra_render::{Gpu, GpuOptions};
use adumbra_shaders::source;
use voxel_points::{BakedScene, exact_light, float_light};

const COUNT: usize = 100_000;

fn generated() -> [BakedScene; 3] {
    let kinds = [GeneratedKind::Primitives, GeneratedKind::City, GeneratedKind::Landscape];
    kinds.map(|kind| BakedScene::new(generate(kind, 3), [0.5, 0.8, 0.35], 1024, 32).in_layout(Layout::Packed))
}

#[test]
fn packed_voxel_counts_the_taps_that_the_cpu_counts() {
    let gpu = kit::gpu();
    for baked in generated() {
        for filter in FILTER_WIDTHS {
            exact_light(&gpu, &baked, filter, COUNT);
        }
        float_light(&gpu, &baked, 9, COUNT);
    }
}

/// Cubes of eight voxels, 20,000 different ones about three times each, so that their pool has wide slots.
fn many_cubes() -> Dag {
    let store = NodeStore::default();
    let hash =
        |v: u64| v.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mut nodes: Vec<NodeState> = (0..1_u64 << 16)
        .map(|place| {
            let cube = hash(place + 1) % 20_000;
            let (once, twice) = (hash(cube ^ 1 << 40), hash(cube ^ 1 << 50));
            let slabs = [u64::MAX, once | twice, once, once & twice, 0, 0, 0, 0];
            store.cube(&slabs.map(|mask| store.slab(mask)))
        })
        .collect();
    // Four beside each other a node; all beyond them is shadowed.
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
fn packed_voxel_with_wide_slots_counts_the_taps_that_the_cpu_counts() {
    let dag = many_cubes();
    let packed = PackedDag::of_dag(&dag).unwrap();
    assert!(packed.top[1] > (1 << 16) - NEAR_UNITS, "{}", packed.top[1]);
    let gpu = kit::gpu();
    let grid = LightGrid { size: dag.size, ..unit_grid() };
    let mut random = Random::new(5, 0);
    let receivers: Vec<_> = (0..COUNT)
        .map(|at| FixedReceiver {
            p_fixed: dag.size.map(|n| (random.unit() * f64::from(n) * f64::from(FIXED_ONE)) as i64),
            gradient: match at % 8 {
                // As steep as a plane may be; rows level; whole steps.
                0 => [0; 2].map(|_| (random.unit() * f64::from(2 * MAX_GRADIENT + 1)) as i32 - MAX_GRADIENT),
                1 => [0, (random.unit() * 600.0) as i32 - 300],
                2 => [0; 2].map(|_| 256 * ((random.unit() * 5.0) as i32 - 2)),
                _ => [0; 2].map(|_| (random.unit() * 600.0) as i32 - 300),
            },
        })
        .collect();
    for (filter, layers) in
        FILTER_WIDTHS.into_iter().flat_map(|f| [(f, TapLayers::Tap), (f, TapLayers::Block)])
    {
        let query = Query::new(&grid, &packed, Bias::default(), filter).unwrap().with_layers(layers);
        let plain = Query::new(&grid, &dag, Bias::default(), filter).unwrap().with_layers(layers);
        let voxel = Voxel::packed(&gpu, &grid, &packed, Bias::default(), filter).unwrap();
        let voxel = voxel.with_layers(&gpu, layers);
        let mut partly = 0;
        for (r, found) in receivers.iter().zip(voxel.lit_taps(&gpu, &receivers).unwrap()) {
            assert_eq!([found, found], [query.lit_taps(r), plain.lit_taps(r)], "{filter} {layers:?}: {r:?}");
            partly += usize::from(found > 0 && found < filter * filter);
        }
        assert!(filter == 1 || partly * 4 > COUNT, "{partly} partly lit");
    }
}

#[test]
fn voxel_layers_are_told_by_name() {
    let gpu = kit::gpu();
    let baked = BakedScene::new(generate(GeneratedKind::City, 3), [0.5, 0.8, 0.35], 1024, 32);
    let baked = baked.in_layout(Layout::Packed);
    let (grid, bias) = (&baked.light.grid, baked.light.settings.bias);
    let fixed = |(p, n)| FixedReceiver::new(&receiver(grid, &bias, p, n), grid.size);
    let receivers: Vec<_> = baked.points(COUNT).into_iter().map(fixed).collect();
    let query = Query::new(grid, baked.light.slabs(), bias, 9).unwrap();
    let lit = [("tap", TapLayers::Tap), ("block", TapLayers::Block)].map(|(name, layers)| {
        let spec = format!("voxel:layers={name}").parse().unwrap();
        let voxel = Voxel::from_spec(&gpu, &spec, Some(&baked.light)).unwrap();
        let lit = voxel.lit_taps(&gpu, &receivers).unwrap();
        let twin: Vec<_> = receivers.iter().map(|r| query.with_layers(layers).lit_taps(r)).collect();
        assert!(lit == twin, "{name}");
        lit
    });
    let apart = lit[0].iter().zip(&lit[1]).filter(|(tap, block)| tap != block).count();
    assert!(apart * 50 > COUNT, "{apart} differ");
}

/// Voxels of one unit under a grid's own axes; sixteen a side.
fn unit_grid() -> LightGrid {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    LightGrid { sun, voxel_size: 1.0, origin: [0.0; 3], axes, size: [16; 3] }
}

#[test]
fn packed_voxel_in_six_bindings_counts_the_same() {
    let packed = &generated()[1];
    let LightBody::Packed(graph) = &packed.light.body else { panic!("not packed") };
    let words = graph.top.len() + graph.units.len() / 2 + 2 * graph.slabs.len();
    let bytes = 4 * (words as u64 / 4).next_power_of_two();
    let options = GpuOptions { max_binding_bytes: Some(bytes), ..GpuOptions::default() };
    let gpu = Gpu::request(&options).unwrap();
    let voxel = Voxel::packed(&gpu, &packed.light.grid, graph, packed.light.settings.bias, 9).unwrap();
    assert_eq!(
        (voxel.bindings().bytes(), voxel.bindings().access().name),
        (4 * words as u64, source::WORDS_6.name)
    );
    exact_light(&gpu, packed, 9, 20_000);
}

/// Sixteen voxels a side, one mask a cube of eight: a pool so large, with pointers of every kind into and beside it.
fn eight_cubes(pool_units: u32, high_bits: u32) -> PackedDag {
    let mut units = vec![0; pool_units as usize];
    let cube = |units: &mut [u16], p: u32| {
        units[0] = 0x0201;
        units[1..5].fill((0x9e37_79b9_u32.wrapping_mul(p + 1) >> 11) as u16);
    };
    // Pointer 1 follows the slots, 3 is near; four are wide, the other two narrow.
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
    PackedDag { size: [16; 3], root_level: 4, top_dims: [1; 3], top, units, slabs: Vec::new() }
}

#[test]
fn packed_voxel_follows_wide_slots_of_every_width() {
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
        for filter in [1, 9] {
            let query = Query::new(&grid, &packed, Bias::default(), filter).unwrap();
            let expected: Vec<_> = receivers.iter().map(|r| query.lit_taps(r)).collect();
            let voxel = Voxel::packed(&gpu, &grid, &packed, Bias::default(), filter).unwrap();
            assert!(voxel.lit_taps(&gpu, &receivers).unwrap() == expected, "{pool_units} {filter}");
            assert!(expected.contains(&0) || filter > 1);
        }
        let masks: HashSet<u64> =
            (0..8).map(|c| packed.slab(c >> 2 << 3, c >> 1 << 3 & 8, c << 3 & 8)).collect();
        assert_eq!(masks.len(), 8, "{pool_units}");
    }
}
