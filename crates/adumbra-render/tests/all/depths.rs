//! A file's switch depths on the GPU against their CPU twins, and its penumbrae against a ray-traced sun
//! disc.

use std::collections::HashSet;

use adumbra::Filter;
use adumbra::gpu::{LookUp, Penumbra as PenumbraSettings};
use adumbra::layout::depths::code::ColumnNode;
use adumbra::layout::depths::leaf::LeafHead;
use adumbra::query::{FixedReceiver, receiver};
use adumbra_render::technique::{ParameterKind, Technique as _};
use adumbra_render::voxel::{BakedLight, SoftTwin, Voxel, VoxelSettings};
use adumbra_render::{Gpu, GpuOptions, TechniqueFiles, build};
use adumbra_scene::{GeneratedKind, generate};
use adumbra_shaders::source;

use crate::kit;
use crate::kit::penumbra::Penumbra;
use crate::voxel_points::BakedScene;

const PENUMBRA: PenumbraSettings = PenumbraSettings { sun_degrees: 2.0, max_radius_texels: 32.0 };

fn soft(penumbra: PenumbraSettings) -> VoxelSettings {
    VoxelSettings { look_up: LookUp { penumbra: Some(penumbra), ..LookUp::default() }, quick: false }
}

fn receivers(baked: &BakedScene, count: usize) -> Vec<FixedReceiver> {
    let (grid, bias) = (&baked.light.grid, baked.light.settings.bias);
    let fixed = |(p, n)| FixedReceiver::new(&receiver(grid, &bias, p, n), baked.light.grid.size);
    baked.points(count).into_iter().map(fixed).collect()
}

fn exact(gpu: &Gpu, baked: &BakedScene, filter: Filter, count: usize) {
    let depths = &baked.light.tree;
    let sampler = baked.light.sampler(filter);
    let settings = VoxelSettings::taps(filter, sampler.bias());
    let light = BakedLight::from_file(gpu, &baked.light, settings).unwrap();
    let width = filter.width();
    assert_eq!(light.bytes(), depths.bytes());
    let counts = light.lit_taps(gpu, &receivers(baked, count)).unwrap();
    let receivers = receivers(baked, count);
    let size = depths.size().map(i64::from);
    let mut partly = 0;
    let answers = light.depths_answers(gpu, &receivers).unwrap();
    for ((r, found), counted) in receivers.iter().zip(answers).zip(counts) {
        let lit = sampler.lit_taps(r);
        assert_eq!([found.lit_taps, counted], [lit; 2], "{filter:?}: {r:?}");
        let [i, j] = [0, 1].map(|a| (r.p_fixed[a] >> 12).clamp(0, size[a] - 1) as u32);
        assert_eq!(found.value, depths.value(i, j), "{i} {j}");
        partly += usize::from(lit > 0 && lit < width * width);
    }
    assert!(width == 1 || partly * 200 > count, "{partly} partly lit");
    if light.bindings().access().name == source::WORDS_1.name {
        let words = (depths.bytes() / 4) as u32;
        for (r, reads) in receivers.iter().zip(light.reads(gpu, &receivers[..500]).unwrap()) {
            assert_eq!(reads.lit_taps, sampler.lit_taps(r), "{filter:?}: {r:?}");
            assert!(reads.words.iter().all(|word| *word < words), "{reads:?}");
            let [x, y] = [0, 1].map(|a| r.p_fixed[a] >> 12);
            // How much nearer than the point the plane may be at a tap, fixed point.
            let steep: i64 = r.gradient.iter().map(|g| i64::from(g.abs())).sum();
            let rise = 16 * steep * i64::from(width / 2 + 1);
            let over = (0..size[0]).contains(&x) && (0..size[1]).contains(&y);
            let is_inside = over && r.p_fixed[2] > rise;
            assert!(!is_inside || reads.words.len() >= 2, "a root takes two words: {reads:?}");
        }
    }
}

#[test]
#[ignore = "slow: draws on the GPU and counts on the CPU"]
fn gpu_taps_and_depths_match_cpu() {
    let gpu = kit::gpu();
    for baked in BakedScene::in_each_frame(1024) {
        let depths = &baked.light.tree;
        let [across, down, _] = depths.size();
        let blocks = (0..down).step_by(8).flat_map(|j| (0..across).step_by(8).map(move |i| [i, j]));
        let (mut leaves, mut by_planes) = (HashSet::new(), [0; 7]);
        for [i, j] in blocks {
            if let (ColumnNode::Leaf { at, .. }, _) = depths.place(i, j)
                && leaves.insert(at)
            {
                by_planes[LeafHead::new(depths.shapes().half(at)).planes() as usize] += 1;
            }
        }
        let slanted = depths.census().slanted_leaves;
        assert!(slanted > 10 && by_planes[1..4].iter().all(|n| *n > 3), "{slanted}, {by_planes:?}");
        for filter in Filter::ALL {
            exact(&gpu, &baked, filter, 4000);
        }
    }
}

#[test]
fn gpu_taps_and_depths_match_cpu_in_six_bindings() {
    let baked = BakedScene::new(generate(GeneratedKind::City, 3), [0.5, 0.8, 0.35], 512);
    let bytes = 4 * (baked.light.tree.bytes() / 16).next_power_of_two();
    let gpu = Gpu::request(&GpuOptions { max_binding_bytes: Some(bytes), ..GpuOptions::default() }).unwrap();
    exact(&gpu, &baked, Filter::Box9, 4000);
}

#[test]
fn gpu_penumbrae_match_cpu() {
    let gpu = kit::gpu();
    for baked in BakedScene::in_each_frame(512) {
        let file = &baked.light;
        let soft = BakedLight::from_file(&gpu, file, soft(PENUMBRA)).unwrap();
        let twin = SoftTwin::new(&file.grid, &file.tree, PENUMBRA.sun_degrees, PENUMBRA.max_radius_texels);
        let receivers = receivers(&baked, 20_000);
        let (mut partly, mut apart) = (0, 0);
        for (i, found) in soft.depths_answers(&gpu, &receivers).unwrap().into_iter().enumerate() {
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
fn penumbrae_beat_fixed_filters_on_a_sun_disc() {
    let angle: f64 = 2.0;
    let mut penumbra = Penumbra::new(angle);
    let baked = BakedScene::new(penumbra.scene.clone(), kit::sun(), 1024);
    let mut error = |settings| {
        let light = BakedLight::from_file(penumbra.renderer.gpu(), &baked.light, settings).unwrap();
        let technique = Voxel::new("voxel".to_owned(), light);
        let technique = penumbra.renderer.prepare(Box::new(technique)).unwrap();
        penumbra.error(technique)
    };
    let soft = error(soft(PenumbraSettings { sun_degrees: angle, ..PENUMBRA }));
    let widths = Filter::ALL.map(|filter| error(VoxelSettings::taps(filter, baked.light.settings.bias)));
    println!("RMSE against a disc of {angle}°: soft {soft:.4}, filters {widths:.4?}");
    assert!(widths.iter().all(|width| soft < 0.7 * width));
}

#[test]
fn voxel_techniques_are_built_by_name() {
    let gpu = kit::gpu();
    let baked = BakedScene::new(generate(GeneratedKind::Primitives, 3), [0.5, 0.8, 0.35], 64);
    let mut file = baked.light;
    let make = |name: &str, file| {
        let files = TechniqueFiles::of(file);
        build(&gpu, &name.parse()?, files).map(|technique| technique.name())
    };
    for name in ["voxel", "voxel:filter=3", "voxel:soft", "voxel:soft:sun-degrees=1.5:radius=8:bias=2"] {
        assert_eq!(make(name, &file).unwrap(), name);
    }
    for (name, says) in [
        ("voxel:sun-degrees=1", "sun-degrees"),
        ("voxel:soft:radius=65", "64"),
        ("voxel:soft:filter=3", "filter"),
    ] {
        assert!(make(name, &file).unwrap_err().to_string().contains(says), "{name}");
    }
    for penumbra in [
        PenumbraSettings { max_radius_texels: 65.0, ..PENUMBRA },
        PenumbraSettings { sun_degrees: f64::NAN, ..PENUMBRA },
    ] {
        assert!(BakedLight::from_file(&gpu, &file, soft(penumbra)).is_err(), "{penumbra:?}");
    }
    // Sliders show the file's own bias, and offer penumbrae.
    file.settings.bias.slope_texels = 0.75;
    let parameters = "voxel"
        .parse::<adumbra_render::TechniqueSpec>()
        .unwrap()
        .describe(TechniqueFiles::of(&file))
        .unwrap();
    let parameter = |key: &str| parameters.iter().find(|p| p.key == key).unwrap();
    assert_eq!(parameter("slope").default, "0.75");
    let ParameterKind::Word { choices } = &parameter("shade").kind else { panic!("{parameters:?}") };
    assert_eq!(choices.len(), 2);
}

/// On the GPU a file takes as many bytes as its sections, whichever technique reads it.
#[test]
fn voxel_techniques_take_the_bytes_of_the_sections() {
    let baked = BakedScene::new(kit::city(), kit::sun(), 256);
    let gpu = kit::gpu();
    for name in ["voxel", "voxel+csm:filter=3", "voxel:soft"] {
        let technique = build(&gpu, &name.parse().unwrap(), TechniqueFiles::of(&baked.light)).unwrap();
        let bytes = technique.bytes() - technique.map().map_or(0, |map| map.bytes());
        assert_eq!(bytes, baked.light.tree.bytes(), "{name}");
    }
}
