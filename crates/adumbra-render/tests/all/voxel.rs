//! Baked voxels on the GPU against their CPU twins: equal counts for every fixed-point receiver, and from f32 positions
//! equal answers unless a point is on a voxel's face.

use adumbra::Layout;
use adumbra::layout::packed::{NEAR_UNITS, POOL_WORDS};
use adumbra::query::FILTER_WIDTHS;
use adumbra_bake::convert::graph_of;
use adumbra_render::voxel::{BakedLight, CubesStore, MAX_WORD_BINDINGS, PageTexture, VoxelSettings};
use adumbra_render::{Baked, Gpu, GpuOptions, RenderError, build};
use adumbra_scene::{GeneratedKind, generate};
use adumbra_tree::Detail;
use adumbra_tree::query as tree_query;
use adumbra_tree::query::{KERNEL_SIDES, Weights};

use crate::kit;
use crate::voxel_points;
use crate::voxel_points::{BakedScene, exact_cubes, exact_light, float_cubes, float_light};

fn generated() -> Vec<BakedScene> {
    let landscape = generate(GeneratedKind::Landscape, 3);
    let mut all = Vec::from(BakedScene::in_each_frame(1024, 256));
    all.push(BakedScene::new(landscape, [0.5, 0.8, 0.35], 1024, 256));
    all
}

const COUNT: usize = 100_000;

#[test]
#[ignore = "slow: draws on the GPU and counts on the CPU"]
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
    let dag = graph_of(&baked.light.body).unwrap();
    let words = dag.top.len() + dag.nodes.len() + 2 * dag.leaf_masks.len();
    let limited = |bytes: u64| {
        Gpu::request(&GpuOptions { max_binding_bytes: Some(bytes), ..GpuOptions::default() }).unwrap()
    };
    // A limit, a power of two, that needs more than two bindings.
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
    let small = limited(4 * words as u64 / 16);
    let settings = VoxelSettings::taps(9, baked.light.settings.bias);
    let Err(error) = BakedLight::from_file(&small, &baked.light, settings) else { panic!("it fits") };
    assert!(matches!(error, RenderError::TooLarge { .. }), "{error}");
    assert_eq!(MAX_WORD_BINDINGS, 6);
}

#[test]
#[ignore = "slow: draws on the GPU and counts on the CPU"]
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
#[ignore = "slow: draws on the GPU and counts on the CPU"]
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
    // Seventeen disjoint regions, two voxels wide.
    let (space, size) = (baked.tree.space, baked.tree.space.voxel_size);
    let range = |axis: usize, i: u32| {
        let from = space.p_min[axis] + size * f64::from(2 + 6 * i);
        [from, from + 2.0 * size]
    };
    baked.tree.regions.list =
        (0..17).map(|i| adumbra_tree::Region { x: range(0, i), z: range(2, i), ..region }).collect();
    let error = voxel_points::try_cubes(&gpu, &baked, CubesStore::Words, (3, Weights::Mean)).err().unwrap();
    assert!(matches!(error, RenderError::VoxelLimit { value: 17, limit: 16, .. }), "{error}");
}

#[test]
#[ignore = "slow: many look-ups on the GPU"]
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
    // Several pages, first with one binding, then with several.
    let pages = adumbra_tree::texture::encode(words, &[1, 2, 3], 64).unwrap();
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
    use adumbra as settings;
    use adumbra::layout::plain as dag;
    use adumbra::query;
    use adumbra_shaders::constants as shaders;
    assert_eq!(shaders::MAX_SLOPE, settings::MAX_SLOPE as f32);
    assert_eq!(shaders::MAX_PLANE_SLOPE, settings::MAX_PLANE_SLOPE as f32);
    assert_eq!((shaders::FIXED_ONE, shaders::FIXED_BITS), (query::FIXED_ONE, query::FIXED_BITS));
    assert_eq!((shaders::GRADIENT_ONE, shaders::GRADIENT_BITS), (query::GRADIENT_ONE, query::GRADIENT_BITS));
    assert_eq!((shaders::MAX_GRADIENT, shaders::MARGIN_VOXELS), (query::MAX_GRADIENT, query::MARGIN_VOXELS));
    assert_eq!(
        (shaders::NORMAL_ONE, shaders::MAX_HEIGHT_CELLS),
        (tree_query::NORMAL_ONE, tree_query::MAX_HEIGHT_CELLS)
    );
    assert_eq!((shaders::PACKED_POOL_WORDS as usize, shaders::PACKED_NEAR_UNITS), (POOL_WORDS, NEAR_UNITS));
    assert_eq!((shaders::TOP_LIT, shaders::TOP_SHADOWED), (dag::LIT, dag::SHADOWED));
    assert_eq!(
        (shaders::DEPTHS_UNIFORM, shaders::DEPTHS_NEVER),
        (adumbra::layout::depths::UNIFORM, adumbra::layout::depths::NEVER)
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
    let refused = "voxel+csm:csm=static=cached".parse::<adumbra_render::TechniqueSpec>().unwrap_err();
    assert!(refused.to_string().contains("static=cached"), "{refused}");
}
