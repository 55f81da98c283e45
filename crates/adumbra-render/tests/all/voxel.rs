//! Baked voxels on the GPU against their CPU twins: equal counts for every fixed-point receiver, and from f32
//! positions equal answers unless a point is on a voxel's face.

use adumbra::Filter;
use adumbra_render::voxel::{BakedLight, MAX_WORD_BINDINGS, VoxelSettings};
use adumbra_render::{Gpu, GpuOptions, RenderError, TechniqueFiles, build};
use adumbra_scene::{GeneratedKind, generate};
use adumbra_testing::placements;

use crate::kit;
use crate::voxel_points::{BakedScene, exact_light, float_light, placed_light};

fn generated() -> Vec<BakedScene> {
    let landscape = generate(GeneratedKind::Landscape, 3);
    let mut all = Vec::from(BakedScene::in_each_frame(1024));
    all.push(BakedScene::new(landscape, [0.5, 0.8, 0.35], 1024));
    all
}

const COUNT: usize = 100_000;

#[test]
#[ignore = "slow: draws on the GPU and counts on the CPU"]
fn gpu_voxel_taps_match_cpu() {
    let gpu = kit::gpu();
    for baked in generated() {
        for filter in Filter::ALL {
            exact_light(&gpu, &baked, filter, COUNT);
        }
    }
}

#[test]
fn gpu_voxel_taps_match_cpu_in_six_bindings() {
    let baked = &generated()[0];
    let words = baked.light.gpu().words().count();
    let limited = |bytes: u64| {
        Gpu::request(&GpuOptions { max_binding_bytes: Some(bytes), ..GpuOptions::default() }).unwrap()
    };
    // A power-of-two limit with which the words need more than two bindings.
    let bytes = 4 * (words / 4).next_power_of_two();
    let gpu = limited(bytes);
    exact_light(&gpu, baked, Filter::Box9, 20_000);
    let small = limited(4 * words / 16);
    let settings = VoxelSettings::taps(Filter::Box9, baked.light.settings.bias);
    let Err(error) = BakedLight::from_file(&small, &baked.light, settings) else { panic!("it fits") };
    assert!(matches!(error, RenderError::TooLarge { .. }), "{error}");
    assert_eq!(MAX_WORD_BINDINGS, 6);
}

#[test]
fn a_small_file_from_f32_positions_differs_only_on_faces() {
    float_light(&kit::gpu(), &BakedScene::in_each_frame(256)[1], Filter::Box9, 10_000);
}

#[test]
fn placed_lights_from_f32_positions_differ_only_on_faces() {
    let gpu = kit::gpu();
    let baked = &BakedScene::in_each_frame(256)[1];
    for (_, placement) in placements().into_iter().step_by(3) {
        placed_light(&gpu, baked, placement, 10_000);
    }
}

#[test]
#[ignore = "slow: many look-ups on the GPU"]
fn voxel_from_f32_positions_differs_only_on_faces() {
    let gpu = kit::gpu();
    for baked in generated() {
        for filter in [Filter::Nearest, Filter::Box9, Filter::Box17] {
            float_light(&gpu, &baked, filter, COUNT);
        }
    }
}

#[test]
fn shader_constants_match_the_library() {
    use adumbra as settings;
    use adumbra::query;
    use adumbra_shaders::constants as shaders;
    assert_eq!(shaders::MAX_SLOPE, settings::MAX_SLOPE as f32);
    assert_eq!(shaders::MAX_PLANE_SLOPE, settings::MAX_PLANE_SLOPE as f32);
    assert_eq!((shaders::FIXED_ONE, shaders::FIXED_BITS), (query::FIXED_ONE, query::FIXED_BITS));
    assert_eq!((shaders::GRADIENT_ONE, shaders::GRADIENT_BITS), (query::GRADIENT_ONE, query::GRADIENT_BITS));
    assert_eq!((shaders::MAX_GRADIENT, shaders::MARGIN_VOXELS), (query::MAX_GRADIENT, query::MARGIN_VOXELS));
    assert_eq!(
        (shaders::DEPTHS_UNIFORM, shaders::DEPTHS_NEVER),
        (adumbra::layout::depths::UNIFORM, adumbra::layout::depths::NEVER)
    );
    assert_eq!(
        (shaders::DEPTHS_ABSENT, shaders::MAX_LEVELS),
        (adumbra::layout::depths::ABSENT, adumbra::file::MAX_LEVELS)
    );
    assert_eq!(shaders::MARCH_EDGE_VOXELS, query::EDGE_VOXELS);
    assert_eq!(shaders::PAGE_LEVEL, adumbra::layout::depths::page::PAGE_LEVEL);
}

#[test]
fn voxel_techniques_keep_their_name_and_voxel_size() {
    let gpu = kit::gpu();
    let baked = BakedScene::new(generate(GeneratedKind::Landscape, 3), [0.5, 0.8, 0.35], 64);
    let voxel = baked.light.grid.voxel_size;
    for name in ["voxel", "voxel:bias=2", "voxel:filter=17:slope=0.5", "voxel+csm:csm=cascades=2/filter=3"] {
        let technique = build(&gpu, &name.parse().unwrap(), TechniqueFiles::of(&baked.light)).unwrap();
        assert_eq!((technique.name().as_str(), technique.texel_world(10.0)), (name, Some(voxel)));
    }
    let refused = "voxel+csm:csm=static=cached".parse::<adumbra_render::TechniqueSpec>().unwrap_err();
    assert!(refused.to_string().contains("static=cached"), "{refused}");
}
