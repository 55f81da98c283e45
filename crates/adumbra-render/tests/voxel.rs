//! Baked voxels on the GPU against their CPU twins: the same count for every receiver in fixed point, and from f32 positions the same
//! answer but where a point lies on a voxel's face.

mod kit;
mod voxel_points;

use std::collections::HashSet;

use adumbra::dag::Dag;
use adumbra::dag::packed::{NEAR_UNITS, POOL_WORDS, PackedDag};
use adumbra::dag::store::{NodeState, NodeStore};
use adumbra::format::{Layout, LightBody};
use adumbra::light::{LightGrid, Sun};
use adumbra::query::{FILTER_WIDTHS, FIXED_ONE, FixedReceiver, KERNEL_SIDES, Query, Weights};
use adumbra::scene::{GeneratedKind, generate};
use adumbra::settings::Bias;
use adumbra::tree::Detail;
use adumbra::verify::Random;
use adumbra_render::voxel::{CubesStore, MAX_WORD_BINDINGS, PageTexture, Voxel};
use adumbra_render::{Baked, Gpu, GpuOptions, RenderError, build};
use adumbra_shaders::source;
use voxel_points::{BakedScene, exact_cubes, exact_light, float_cubes, float_light};

fn generated() -> Vec<BakedScene> {
    let kinds = [GeneratedKind::Primitives, GeneratedKind::City, GeneratedKind::Landscape];
    kinds.map(|kind| BakedScene::new(generate(kind, 3), [0.5, 0.8, 0.35], 1024, 256)).into()
}

const COUNT: usize = 100_000;

#[test]
fn voxel_counts_the_taps_that_the_cpu_counts() {
    let gpu = kit::gpu();
    for baked in generated() {
        for filter in FILTER_WIDTHS {
            exact_light(&gpu, &baked, filter, COUNT);
        }
    }
}

#[test]
fn voxel_in_six_bindings_counts_the_same() {
    let baked = &generated()[0];
    let dag = baked.light.graph().unwrap();
    let words = dag.top.len() + dag.nodes.len() + 2 * dag.slabs.len();
    let limited = |bytes: u64| {
        Gpu::request(&GpuOptions { max_binding_bytes: Some(bytes), ..GpuOptions::default() }).unwrap()
    };
    // More than two bindings of a power of two.
    let bytes = 4 * (words as u64 / 4).next_power_of_two();
    let gpu = limited(bytes);
    exact_light(&gpu, baked, 9, 20_000);
    exact_cubes(
        &limited(4096),
        &BakedScene::new(generate(GeneratedKind::Primitives, 3), [0.5, 0.8, 0.35], 64, 32),
        CubesStore::Words,
        (3, Weights::Mean),
        20_000,
    );
    let grid = &baked.light.grid;
    let small = limited(4 * words as u64 / 16);
    let Err(error) = Voxel::new(&small, grid, &dag, baked.light.settings.bias, 9) else { panic!("it fits") };
    assert!(matches!(error, RenderError::TooLarge { .. }), "{error}");
    assert_eq!(MAX_WORD_BINDINGS, 6);
}

#[test]
fn packed_voxel_counts_the_taps_that_the_cpu_counts() {
    let gpu = kit::gpu();
    for baked in generated() {
        let packed = baked.in_layout(Layout::Packed);
        for filter in FILTER_WIDTHS {
            exact_light(&gpu, &packed, filter, COUNT);
        }
        float_light(&gpu, &packed, 9, COUNT);
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
        .map(|_| FixedReceiver {
            p_fixed: dag.size.map(|n| (random.unit() * f64::from(n) * f64::from(FIXED_ONE)) as i64),
            gradient: [0; 2].map(|_| (random.unit() * 600.0) as i32 - 300),
        })
        .collect();
    for filter in FILTER_WIDTHS {
        let query = Query::new(&grid, &packed, Bias::default(), filter).unwrap();
        let plain = Query::new(&grid, &dag, Bias::default(), filter).unwrap();
        let voxel = Voxel::packed(&gpu, &grid, &packed, Bias::default(), filter).unwrap();
        let mut partly = 0;
        for (r, found) in receivers.iter().zip(voxel.lit_taps(&gpu, &receivers).unwrap()) {
            assert_eq!([found, found], [query.lit_taps(r), plain.lit_taps(r)], "filter {filter}: {r:?}");
            partly += usize::from(found > 0 && found < filter * filter);
        }
        assert!(filter == 1 || partly * 4 > COUNT, "{partly} partly lit");
    }
}

/// Voxels of one unit under a grid's own axes; sixteen a side.
fn unit_grid() -> LightGrid {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    LightGrid { sun, voxel_size: 1.0, origin: [0.0; 3], axes, size: [16; 3] }
}

#[test]
fn packed_voxel_in_six_bindings_counts_the_same() {
    let packed = generated()[1].in_layout(Layout::Packed);
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
    exact_light(&gpu, &packed, 9, 20_000);
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

#[test]
fn voxel_cubes_count_the_taps_that_the_cpu_counts() {
    let gpu = kit::gpu();
    for baked in generated() {
        for side in KERNEL_SIDES {
            for weights in [Weights::Mean, Weights::Poisson] {
                exact_cubes(&gpu, &baked, CubesStore::Words, (side, weights), COUNT);
            }
        }
    }
}

#[test]
fn voxel_texture_counts_the_taps_that_the_cpu_counts() {
    let gpu = kit::gpu();
    for baked in generated() {
        for side in KERNEL_SIDES {
            exact_cubes(&gpu, &baked, CubesStore::Texels, (side, Weights::Mean), COUNT);
        }
        exact_cubes(&gpu, &baked, CubesStore::Decoded, (3, Weights::Poisson), COUNT);
    }
}

#[test]
fn voxel_cubes_with_regions_count_the_same_and_stay_within_their_limit() {
    let gpu = kit::gpu();
    let rings = Detail::Rings { center_xz: [3.0, -5.0], radii: vec![8.0, 20.0, 40.0] };
    let scene = generate(GeneratedKind::Landscape, 3);
    let mut baked = BakedScene::with_detail(scene, [0.5, 0.8, 0.35], 64, 128, rings);
    for side in KERNEL_SIDES {
        exact_cubes(&gpu, &baked, CubesStore::Words, (side, Weights::Mean), 30_000);
        float_cubes(&gpu, &baked, (side, Weights::Mean), 30_000);
    }
    let region = baked.tree.regions.list[0];
    // Seventeen apart from each other, two voxels wide.
    let (space, size) = (baked.tree.space, baked.tree.space.voxel_size);
    let range = |axis: usize, i: u32| {
        let from = space.p_min[axis] + size * f64::from(2 + 6 * i);
        [from, from + 2.0 * size]
    };
    baked.tree.regions.list =
        (0..17).map(|i| adumbra::tree::Region { x: range(0, i), z: range(2, i), ..region }).collect();
    let error = voxel_points::try_cubes(&gpu, &baked, CubesStore::Words, (3, Weights::Mean)).err().unwrap();
    assert!(matches!(error, RenderError::VoxelLimit { value: 17, limit: 16, .. }), "{error}");
}

#[test]
fn voxel_from_f32_positions_differs_only_on_faces() {
    let gpu = kit::gpu();
    for baked in generated() {
        for filter in [1, 9, 17] {
            float_light(&gpu, &baked, filter, COUNT);
        }
        for side in KERNEL_SIDES {
            float_cubes(&gpu, &baked, (side, Weights::Mean), COUNT);
        }
    }
}

#[test]
fn texture_is_decoded_bit_for_bit() {
    let gpu = kit::gpu();
    let baked = &generated()[1];
    let words = baked.words();
    // Several pages, then several bindings.
    let pages = adumbra::texture::encode(words, &[1, 2, 3], 64).unwrap();
    assert!(pages.len() > 2, "{}", pages.len());
    for bytes in [1 << 27, 4 * (words.len() as u64 / 4).next_power_of_two()] {
        let options = GpuOptions { max_binding_bytes: Some(bytes), ..GpuOptions::default() };
        let gpu = Gpu::request(&options).unwrap();
        let decoded = PageTexture::new(&gpu, &pages).unwrap().decode(&gpu, words.len() as u64).unwrap();
        let mut read = Vec::new();
        for buffer in decoded.buffers() {
            let bytes = adumbra_render::readback::read_buffer(&gpu, buffer).unwrap();
            read.extend(bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)));
        }
        assert_eq!(&read[..words.len()], words);
    }
    let mut damaged = pages;
    damaged[0].rgba[5] ^= 1;
    assert!(matches!(PageTexture::new(&gpu, &damaged), Err(RenderError::Pages { .. })));
}

#[test]
fn constants_of_shaders_are_those_of_the_library() {
    use adumbra::{dag, query, settings};
    use adumbra_shaders::constants as shaders;
    assert_eq!(shaders::MAX_SLOPE, settings::MAX_SLOPE as f32);
    assert_eq!((shaders::FIXED_ONE, shaders::FIXED_BITS), (query::FIXED_ONE, query::FIXED_BITS));
    assert_eq!((shaders::GRADIENT_ONE, shaders::GRADIENT_BITS), (query::GRADIENT_ONE, query::GRADIENT_BITS));
    assert_eq!((shaders::MAX_GRADIENT, shaders::MARGIN_VOXELS), (query::MAX_GRADIENT, query::MARGIN_VOXELS));
    assert_eq!(
        (shaders::NORMAL_ONE, shaders::MAX_HEIGHT_CELLS),
        (query::NORMAL_ONE, query::MAX_HEIGHT_CELLS)
    );
    assert_eq!((shaders::PACKED_POOL_WORDS as usize, shaders::PACKED_NEAR_UNITS), (POOL_WORDS, NEAR_UNITS));
    assert_eq!((shaders::TOP_LIT, shaders::TOP_SHADOWED), (dag::LIT, dag::SHADOWED));
    assert_eq!(
        (shaders::HIERARCHY_UNIFORM, shaders::HIERARCHY_NEVER),
        (adumbra::hierarchy::UNIFORM, adumbra::hierarchy::NEVER)
    );
}

#[test]
fn voxel_techniques_keep_the_name_they_are_asked_by_and_know_their_cells() {
    let gpu = kit::gpu();
    let rings = Detail::Rings { center_xz: [3.0, -5.0], radii: vec![8.0, 20.0] };
    let scene = generate(GeneratedKind::Landscape, 3);
    let baked = BakedScene::with_detail(scene, [0.5, 0.8, 0.35], 64, 128, rings);
    let packed = baked.in_layout(Layout::Packed);
    let files = Baked { light: Some(&baked.light), tree: Some(&baked.tree) };
    let levels = baked.tree.space.depth - baked.tree.regions.base_depth;
    assert_eq!(levels, 2);
    let cell = 4.0 * baked.tree.space.voxel_size;
    let voxel = baked.light.grid.voxel_size;
    for (name, edge) in [
        ("voxel", voxel),
        ("voxel:bias=2", voxel),
        ("voxel:filter=17:slope=0.5", voxel),
        ("voxel+csm:csm=cascades=2/filter=3", voxel),
        ("voxel-cubes:normal=1", cell),
        ("voxel-texture:read=buffer", cell),
    ] {
        let technique = build(&gpu, &name.parse().unwrap(), files).unwrap();
        assert_eq!((technique.name().as_str(), technique.texel_world(10.0)), (name, Some(edge)));
        let from_packed = build(&gpu, &name.parse().unwrap(), Baked { light: Some(&packed.light), ..files });
        let less = technique.bytes() - from_packed.unwrap().bytes();
        assert_eq!(less > 0, !name.starts_with("voxel-"), "{name}");
    }
    let refused = build(&gpu, &"voxel+csm:csm=static=cached".parse().unwrap(), files).err().unwrap();
    assert!(refused.to_string().contains("static=cached"), "{refused}");
}
