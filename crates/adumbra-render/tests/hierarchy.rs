//! The hierarchy on the GPU against its CPU twins, and its penumbrae against a sun's disc.

mod kit;
mod voxel_points;

use std::sync::atomic::AtomicBool;

use adumbra::bake::{Options, Size, bake_hierarchy};
use adumbra::format::ShadowFile;
use adumbra::hierarchy::Hierarchy;
use adumbra::query::{FILTER_WIDTHS, FixedReceiver, Query, TapLayers, receiver};
use adumbra::scene::{GeneratedKind, generate};
use adumbra_render::technique::{ParameterKind, describe};
use adumbra_render::voxel::{HierarchyFilter, SoftTwin, VoxelHierarchy};
use adumbra_render::{Baked, Gpu, GpuOptions, build};
use kit::penumbra::Penumbra;
use voxel_points::BakedScene;

const SOFT: HierarchyFilter = HierarchyFilter::Soft { angle_degrees: 2.0, max_radius_texels: 32.0 };

/// The same bake into a hierarchy.
fn hierarchy_of(baked: &BakedScene) -> Hierarchy {
    let size = Size::Resolution(baked.light.settings.resolution.into());
    let options = Options::new(baked.light.grid.sun, size);
    let found = bake_hierarchy(&baked.scene, &options, true, &|_| {}, &AtomicBool::new(false)).unwrap();
    assert_eq!(found.grid, baked.light.grid);
    found.hierarchy
}

fn receivers(baked: &BakedScene, count: usize) -> Vec<FixedReceiver> {
    let (grid, bias) = (&baked.light.grid, baked.light.settings.bias);
    let fixed = |(p, n)| FixedReceiver::new(&receiver(grid, &bias, p, n), baked.light.grid.size);
    baked.points(count).into_iter().map(fixed).collect()
}

fn exact(gpu: &Gpu, baked: &BakedScene, hierarchy: &Hierarchy, filter: u32, count: usize) {
    for layers in [TapLayers::Tap, TapLayers::Block] {
        exact_of(gpu, baked, hierarchy, (filter, layers), count);
    }
}

fn exact_of(
    gpu: &Gpu,
    baked: &BakedScene,
    hierarchy: &Hierarchy,
    (filter, layers): (u32, TapLayers),
    count: usize,
) {
    let (grid, bias) = (&baked.light.grid, baked.light.settings.bias);
    let query = Query::new(grid, hierarchy, bias, filter).unwrap().with_layers(layers);
    let found = VoxelHierarchy::new(gpu, grid, hierarchy, bias, HierarchyFilter::Taps(filter)).unwrap();
    let found = found.with_layers(gpu, layers);
    let receivers = receivers(baked, count);
    let size = hierarchy.size.map(i64::from);
    let mut partly = 0;
    for (r, found) in receivers.iter().zip(found.answers(gpu, &receivers).unwrap()) {
        let lit = query.lit_taps(r);
        assert_eq!(found.lit_taps, lit, "filter {filter}: {r:?}");
        let [i, j] = [0, 1].map(|a| (r.p_fixed[a] >> 12).clamp(0, size[a] - 1) as u32);
        assert_eq!(found.value, hierarchy.value(i, j), "{i} {j}");
        partly += usize::from(lit > 0 && lit < filter * filter);
    }
    assert!(filter == 1 || partly * 200 > count, "{partly} partly lit");
}

#[test]
fn hierarchy_counts_the_taps_and_knows_the_depths_that_the_cpu_does() {
    let gpu = kit::gpu();
    for kind in [GeneratedKind::Primitives, GeneratedKind::City] {
        let baked = BakedScene::new(generate(kind, 3), [0.5, 0.8, 0.35], 1024, 32);
        let hierarchy = hierarchy_of(&baked);
        assert_eq!(hierarchy.validate(), Ok(()));
        let census = hierarchy.census();
        assert!(
            census.slanted_leaves > 10 && census.leaves_by_planes[1..4].iter().all(|n| *n > 10),
            "{census:?}"
        );
        for filter in FILTER_WIDTHS {
            exact(&gpu, &baked, &hierarchy, filter, 4000);
        }
    }
}

#[test]
fn hierarchy_in_six_bindings_answers_the_same() {
    let baked = BakedScene::new(generate(GeneratedKind::City, 3), [0.5, 0.8, 0.35], 512, 32);
    let hierarchy = hierarchy_of(&baked);
    let bytes = 4 * (hierarchy.bytes() / 16).next_power_of_two();
    let gpu = Gpu::request(&GpuOptions { max_binding_bytes: Some(bytes), ..GpuOptions::default() }).unwrap();
    exact(&gpu, &baked, &hierarchy, 9, 4000);
}

#[test]
fn hierarchy_penumbrae_are_those_of_the_cpu() {
    let gpu = kit::gpu();
    let baked = BakedScene::new(generate(GeneratedKind::City, 3), [0.5, 0.8, 0.35], 512, 32);
    let hierarchy = hierarchy_of(&baked);
    let soft =
        VoxelHierarchy::new(&gpu, &baked.light.grid, &hierarchy, baked.light.settings.bias, SOFT).unwrap();
    let twin = SoftTwin::new(&hierarchy, 2.0, 32.0);
    let receivers = receivers(&baked, 20_000);
    let (mut partly, mut apart) = (0, 0);
    for (i, found) in soft.answers(&gpu, &receivers).unwrap().into_iter().enumerate() {
        let expected = twin.visibility(&receivers[i], [i as u32, 0]);
        partly += usize::from(expected > 0.0 && expected < 1.0);
        // A tap at a texel's border may fall on either side.
        apart += usize::from((found.soft - expected).abs() > 1e-3);
    }
    assert!(partly > 1000 && apart * 200 <= receivers.len(), "{partly} partly lit, {apart} apart");
}

/// A plate in the air and a post over flat ground, under a sun of two degrees.
#[test]
fn hierarchy_penumbrae_are_nearer_to_a_sun_disc_than_any_filter_of_one_width() {
    let angle: f64 = 2.0;
    let mut penumbra = Penumbra::new(angle);
    let baked = BakedScene::new(penumbra.scene.clone(), kit::sun(), 1024, 32);
    let (grid, bias) = (&baked.light.grid, baked.light.settings.bias);
    let hierarchy = hierarchy_of(&baked);
    let mut error = |filter| {
        let technique = VoxelHierarchy::new(penumbra.renderer.gpu(), grid, &hierarchy, bias, filter).unwrap();
        let technique = penumbra.renderer.prepare(Box::new(technique)).unwrap();
        penumbra.error(technique)
    };
    let soft = error(SOFT);
    let widths = FILTER_WIDTHS.map(|width| error(HierarchyFilter::Taps(width)));
    println!("RMSE against a disc of {angle}°: soft {soft:.4}, filters {widths:.4?}");
    assert!(widths.iter().all(|width| soft < 0.7 * width));
}

#[test]
fn hierarchy_techniques_are_told_by_name() {
    let gpu = kit::gpu();
    let baked = BakedScene::new(generate(GeneratedKind::Primitives, 3), [0.5, 0.8, 0.35], 64, 32);
    let hierarchy = hierarchy_of(&baked);
    let file = ShadowFile::hierarchy(baked.light.grid, baked.light.settings, hierarchy.clone());
    let make = |name: &str, file| {
        let files = Baked { light: Some(file), tree: None };
        build(&gpu, &name.parse().unwrap(), files).map(|technique| technique.name())
    };
    for name in ["voxel", "voxel:filter=3", "voxel:soft", "voxel:soft:angle=1.5:radius=8:bias=2"] {
        assert_eq!(make(name, &file).unwrap(), name);
    }
    for (name, says) in
        [("voxel:angle=1", "angle"), ("voxel:soft:radius=65", "64"), ("voxel:soft:filter=3", "filter")]
    {
        assert!(make(name, &file).unwrap_err().to_string().contains(says), "{name}");
    }
    for filter in [
        HierarchyFilter::Soft { angle_degrees: 2.0, max_radius_texels: 65.0 },
        HierarchyFilter::Soft { angle_degrees: f64::NAN, max_radius_texels: 32.0 },
        HierarchyFilter::Taps(4),
    ] {
        let made =
            VoxelHierarchy::new(&gpu, &baked.light.grid, &hierarchy, baked.light.settings.bias, filter);
        assert!(made.is_err(), "{filter:?}");
    }
    let refused = make("voxel:soft", &baked.light).unwrap_err().to_string();
    assert!(refused.contains("--layout hierarchy"), "{refused}");
    // What sliders show is the file's own: its bias, and penumbrae where it has them.
    let mut other = file;
    other.settings.bias.slope_texels = 0.75;
    for (file, shades) in [(&other, 2), (&baked.light, 1)] {
        let told = describe(&"voxel".parse().unwrap(), Baked { light: Some(file), tree: None }).unwrap();
        let parameter = |key: &str| told.iter().find(|p| p.key == key).unwrap();
        assert_eq!(parameter("slope").default, file.settings.bias.slope_texels.to_string());
        let ParameterKind::Word { choices } = &parameter("shade").kind else { panic!("{told:?}") };
        assert_eq!(choices.len(), shades);
    }
}
