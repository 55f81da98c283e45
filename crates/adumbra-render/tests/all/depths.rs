//! The layout `depths` on the GPU against its CPU twins, and its penumbrae against a ray-traced sun disc.

use adumbra::layout::depths::DepthTree;
use adumbra::query::{FILTER_WIDTHS, FixedReceiver, receiver};
use adumbra::{Frame, LightBody, Query, ShadowFile};
use adumbra_bake::convert::graph_of_depths;
use adumbra_bake::{BakeOptions, FrameChoice, Size};
use adumbra_render::technique::{ParameterKind, Technique as _};
use adumbra_render::voxel::{BakedLight, SoftTwin, Voxel, VoxelFilter, VoxelSettings};
use adumbra_render::{Answer, Baked, Gpu, GpuOptions, Renderer, SceneOptions, Shot, build};
use adumbra_scene::{GeneratedKind, generate};
use adumbra_shaders::source;
use adumbra_testing::bake_depths;

use crate::kit;
use crate::kit::penumbra::Penumbra;
use crate::voxel_points::BakedScene;

const SOFT: VoxelFilter = VoxelFilter::Soft { angle_degrees: 2.0, max_radius_texels: 32.0 };

/// Bakes a scene again, into the layout `depths`.
fn depths_of(baked: &BakedScene) -> DepthTree {
    let grid = &baked.light.grid;
    let frame = match grid.frame {
        Frame::Light => FrameChoice::Light,
        Frame::Oblique { yaw_radians } => FrameChoice::ObliqueAt(yaw_radians),
    };
    let size = Size::Resolution(baked.light.settings.resolution.into());
    let options = BakeOptions { frame, ..BakeOptions::new(grid.sun, size) };
    bake_depths(&baked.scene, &options).unwrap()
}

fn receivers(baked: &BakedScene, count: usize) -> Vec<FixedReceiver> {
    let (grid, bias) = (&baked.light.grid, baked.light.settings.bias);
    let fixed = |(p, n)| FixedReceiver::new(&receiver(grid, &bias, p, n), baked.light.grid.size);
    baked.points(count).into_iter().map(fixed).collect()
}

fn exact(gpu: &Gpu, baked: &BakedScene, depths: &DepthTree, filter: u32, count: usize) {
    let (grid, bias) = (&baked.light.grid, baked.light.settings.bias);
    let query = Query::new(grid, depths, bias, filter).unwrap();
    let settings = VoxelSettings::taps(filter, bias);
    let body = LightBody::Depths(depths.clone());
    let light = BakedLight::new(gpu, grid, &body, settings).unwrap();
    assert_eq!(light.bytes(), depths.bytes());
    let counts = light.lit_taps(gpu, &receivers(baked, count)).unwrap();
    let receivers = receivers(baked, count);
    let size = depths.size.map(i64::from);
    let mut partly = 0;
    let answers = light.depths_answers(gpu, &receivers).unwrap().unwrap();
    for ((r, found), counted) in receivers.iter().zip(answers).zip(counts) {
        let lit = query.lit_taps(r);
        assert_eq!([found.lit_taps, counted], [lit; 2], "filter {filter}: {r:?}");
        let [i, j] = [0, 1].map(|a| (r.p_fixed[a] >> 12).clamp(0, size[a] - 1) as u32);
        assert_eq!(found.value, depths.value(i, j), "{i} {j}");
        partly += usize::from(lit > 0 && lit < filter * filter);
    }
    assert!(filter == 1 || partly * 200 > count, "{partly} partly lit");
    if light.bindings().access().name == source::WORDS_1.name {
        let words = (depths.bytes() / 4) as u32;
        for (r, reads) in receivers.iter().zip(light.reads(gpu, &receivers[..500]).unwrap()) {
            assert_eq!(reads.lit_taps, query.lit_taps(r), "filter {filter}: {r:?}");
            assert!(reads.words.iter().all(|word| *word < words), "{reads:?}");
            let [x, y] = [0, 1].map(|a| r.p_fixed[a] >> 12);
            // How much nearer than the point the plane may be at a tap, fixed point.
            let steep: i64 = r.gradient.iter().map(|g| i64::from(g.abs())).sum();
            let rise = 16 * steep * i64::from(filter / 2 + 1);
            let over = (0..size[0]).contains(&x) && (0..size[1]).contains(&y);
            let is_inside = over && r.p_fixed[2] > rise;
            assert!(!is_inside || reads.words.len() >= 2, "a root takes two words: {reads:?}");
        }
    }
}

#[test]
#[ignore = "slow: draws on the GPU and counts on the CPU"]
fn depths_on_the_gpu_count_the_taps_and_know_the_depths_that_the_cpu_does() {
    let gpu = kit::gpu();
    for baked in BakedScene::in_each_frame(1024, 32) {
        let depths = depths_of(&baked);
        assert_eq!(depths.validate(), Ok(()));
        let census = depths.census();
        assert!(
            census.slanted_leaves > 10 && census.leaves_by_planes[1..4].iter().all(|n| *n > 3),
            "{census:?}"
        );
        for filter in FILTER_WIDTHS {
            exact(&gpu, &baked, &depths, filter, 4000);
        }
    }
}

#[test]
fn depths_in_six_bindings_answer_as_in_one() {
    let baked = BakedScene::new(generate(GeneratedKind::City, 3), [0.5, 0.8, 0.35], 512, 32);
    let depths = depths_of(&baked);
    let bytes = 4 * (depths.bytes() / 16).next_power_of_two();
    let gpu = Gpu::request(&GpuOptions { max_binding_bytes: Some(bytes), ..GpuOptions::default() }).unwrap();
    exact(&gpu, &baked, &depths, 9, 4000);
}

#[test]
fn depths_penumbrae_are_those_of_the_cpu() {
    let gpu = kit::gpu();
    for baked in BakedScene::in_each_frame(512, 32) {
        let depths = depths_of(&baked);
        let settings = VoxelSettings { filter: SOFT, ..VoxelSettings::taps(1, baked.light.settings.bias) };
        let body = LightBody::Depths(depths.clone());
        let soft = BakedLight::new(&gpu, &baked.light.grid, &body, settings).unwrap();
        let twin = SoftTwin::new(&baked.light.grid, &depths, 2.0, 32.0);
        let receivers = receivers(&baked, 20_000);
        let (mut partly, mut apart) = (0, 0);
        for (i, found) in soft.depths_answers(&gpu, &receivers).unwrap().unwrap().into_iter().enumerate() {
            let expected = twin.visibility(&receivers[i], [i as u32, 0]);
            partly += usize::from(expected > 0.0 && expected < 1.0);
            // A tap on the border between two texels may fall on either side.
            apart += usize::from((found.soft - expected).abs() > 1e-3);
        }
        assert!(partly > 500 && apart * 200 <= receivers.len(), "{partly} partly lit, {apart} apart");
    }
}

/// Uses a raised plate and a post over flat ground, under a sun of two degrees.
#[test]
fn depths_penumbrae_are_nearer_to_a_sun_disc_than_any_filter_of_one_width() {
    let angle: f64 = 2.0;
    let mut penumbra = Penumbra::new(angle);
    let baked = BakedScene::new(penumbra.scene.clone(), kit::sun(), 1024, 32);
    let (grid, bias) = (&baked.light.grid, baked.light.settings.bias);
    let body = LightBody::Depths(depths_of(&baked));
    let mut error = |filter| {
        let settings = VoxelSettings { filter, ..VoxelSettings::taps(1, bias) };
        let light = BakedLight::new(penumbra.renderer.gpu(), grid, &body, settings).unwrap();
        let technique = Voxel::new("voxel".to_owned(), light);
        let technique = penumbra.renderer.prepare(Box::new(technique)).unwrap();
        penumbra.error(technique)
    };
    let soft = error(SOFT);
    let widths = FILTER_WIDTHS.map(|width| error(VoxelFilter::Taps(width)));
    println!("RMSE against a disc of {angle}°: soft {soft:.4}, filters {widths:.4?}");
    assert!(widths.iter().all(|width| soft < 0.7 * width));
}

#[test]
fn depths_techniques_are_chosen_by_name() {
    let gpu = kit::gpu();
    let baked = BakedScene::new(generate(GeneratedKind::Primitives, 3), [0.5, 0.8, 0.35], 64, 32);
    let depths = depths_of(&baked);
    let file = ShadowFile { body: LightBody::Depths(depths), ..baked.light };
    let make = |name: &str, file| {
        let files = Baked { light: Some(file), tree: None };
        build(&gpu, &name.parse()?, files).map(|technique| technique.name())
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
        VoxelFilter::Soft { angle_degrees: 2.0, max_radius_texels: 65.0 },
        VoxelFilter::Soft { angle_degrees: f64::NAN, max_radius_texels: 32.0 },
        VoxelFilter::Taps(4),
    ] {
        let settings = VoxelSettings { filter, ..VoxelSettings::taps(1, baked.light.settings.bias) };
        assert!(BakedLight::from_file(&gpu, &file, settings).is_err(), "{filter:?}");
    }
    let settings = VoxelSettings { filter: SOFT, ..VoxelSettings::taps(1, baked.light.settings.bias) };
    assert!(BakedLight::from_file(&gpu, &baked.light, settings).is_err());
    let refused = make("voxel:soft", &baked.light).unwrap_err().to_string();
    assert!(refused.contains("layout depths"), "{refused}");
    // Sliders show the file's own bias, and offer penumbrae only if the file supports them.
    let mut other = file;
    other.settings.bias.slope_texels = 0.75;
    for (file, shadows) in [(&other, 2), (&baked.light, 1)] {
        let parameters = "voxel"
            .parse::<adumbra_render::TechniqueSpec>()
            .unwrap()
            .describe(Baked { light: Some(file), tree: None })
            .unwrap();
        let parameter = |key: &str| parameters.iter().find(|p| p.key == key).unwrap();
        assert_eq!(parameter("slope").default, file.settings.bias.slope_texels.to_string());
        let ParameterKind::Word { choices } = &parameter("shade").kind else { panic!("{parameters:?}") };
        assert_eq!(choices.len(), shadows);
    }
}

/// On the GPU a file takes as many bytes as its sections, whichever technique reads it, and it gives the same pictures
/// as its graph.
#[test]
fn voxel_csm_takes_depths_as_they_are_and_draws_what_their_graph_draws() {
    let scene = kit::city();
    let baked = BakedScene::new(scene, kit::sun(), 1024, 32);
    let depths = depths_of(&baked);
    let (grid, settings) = (baked.light.grid, baked.light.settings);
    let graph = ShadowFile { grid, settings, body: LightBody::Plain(graph_of_depths(&depths).unwrap()) };
    let sections = 4 * (2 * depths.top.len() + 2 * depths.wide.len() + depths.code.len()) as u64;
    let file = ShadowFile { grid, settings, body: LightBody::Depths(depths) };
    let mut renderer = Renderer::new(kit::gpu(), &baked.scene, SceneOptions::default()).unwrap();
    renderer.set_movers(&generate(GeneratedKind::Primitives, 3), SceneOptions::default()).unwrap();
    let shot = Shot { camera: kit::camera(240, 160), towards_sun: kit::sun(), number: 0 };
    let mut draw = |name: &str, file: &ShadowFile| {
        let files = Baked { light: Some(file), tree: None };
        let technique = build(renderer.gpu(), &name.parse().unwrap(), files).unwrap();
        let bytes = technique.bytes() - technique.map().map_or(0, |map| map.bytes());
        let mut prepared = renderer.prepare(technique).unwrap();
        renderer.draw(&shot, &mut prepared, Answer::Visibility).unwrap();
        (bytes, renderer.read_factor(&prepared).unwrap(), renderer.read_picture().unwrap())
    };
    for name in ["voxel+csm", "voxel+csm:filter=3", "voxel"] {
        let (bytes, factors, picture) = draw(name, &file);
        let (graph_bytes, graph_factors, graph_picture) = draw(name, &graph);
        assert_eq!(bytes, sections, "{name}");
        assert!(bytes < graph_bytes, "{name}: {bytes} {graph_bytes}");
        assert!(factors == graph_factors && picture == graph_picture, "{name}");
    }
    assert_eq!(draw("voxel:soft", &file).0, sections);
}
