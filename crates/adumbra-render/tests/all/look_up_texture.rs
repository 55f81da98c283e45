//! The look-up texture against the CPU, in each frame and format.

use adumbra::gpu::{Bindings, LookUp, LookUpTexture, TexelFormat};
use adumbra::{Filter, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_render::gpu::Gpu;
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, generate};
use adumbra_testing::placements;

use crate::kit;
use crate::shade;

/// Points in and around a box, with upward normals or none.
fn points(min: [f64; 3], max: [f64; 3], anchor: [f32; 3], count: usize) -> Vec<shade::Point> {
    let mut random = Random::for_batch(29, 0);
    (0..count)
        .map(|i| {
            let p = [0, 1, 2].map(|a| min[a] + (1.2 * random.unit() - 0.1) * (max[a] - min[a]));
            let [x, y, z] = [0, 1, 2].map(|a| (p[a] - f64::from(anchor[a])) as f32);
            let up = if i % 2 == 0 { 1.0 } else { 0.0 };
            [[x, y, z, 0.0], [0.0, up, 0.0, 0.0]]
        })
        .collect()
}

/// Returns the answers of a texture.
fn answers(gpu: &Gpu, texture: &LookUpTexture, format: TexelFormat, points: &[shade::Point]) -> Vec<f32> {
    let view = shade::upload(&gpu.device, &gpu.queue, texture, format);
    let look_up = texture.wgsl(format, Bindings::default()) + shade::FILTERED;
    let resources = [wgpu::BindingResource::TextureView(&view)];
    shade::shade(&gpu.device, &gpu.queue, (&look_up, &resources), points).unwrap()
}

#[test]
fn look_up_texture_matches_cpu_in_every_frame_and_format() {
    const COUNT: usize = 20_000;
    let gpu = kit::gpu();
    let scene = generate(GeneratedKind::City, 3);
    let bounds = scene.bounds();
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    for frame in [FrameChoice::Light, FrameChoice::ObliqueAt(0.4)] {
        let options = BakeOptions::new(sun, Size::Resolution(1024)).with(|o| o.frame = frame);
        let file = Bake::with_options(&scene, &options).in_memory().unwrap();
        // Narrow rows, so that the words fill many of them.
        let mut texture =
            LookUpTexture::new(&file, &LookUp { filter: Filter::Nearest, ..LookUp::default() }, 2048)
                .unwrap();
        assert!(texture.height() > 50, "{}", texture.height());
        texture.set_look_up(&LookUp { filter: Filter::Box5, ..LookUp::default() }).unwrap();
        let anchor = texture.anchor_world();
        let points = points(bounds.min, bounds.max, anchor, COUNT);
        let sampler = file.sampler(Filter::Box5);
        let mut first: Option<Vec<f32>> = None;
        for format in [TexelFormat::R32Uint, TexelFormat::Rgba8Unorm] {
            let found = answers(&gpu, &texture, format, &points);
            let off = points.iter().zip(&found).filter(|([p, n], found)| {
                let p_world = [0, 1, 2].map(|a| f64::from(anchor[a]) + f64::from(p[a]));
                let normal = (n[1] > 0.0).then_some([0.0, 1.0, 0.0]);
                (sampler.visibility(p_world, normal) - **found).abs() > 1e-5
            });
            let off = off.count();
            assert!(off * 2000 <= COUNT, "{frame:?} {format:?}: {off} of {COUNT} points differ");
            let partly = found.iter().filter(|v| **v > 0.0 && **v < 1.0).count();
            assert!(partly * 100 > COUNT, "{frame:?} {format:?}: {partly} points are partly lit");
            // Both formats give bit-identical answers.
            assert!(*first.get_or_insert_with(|| found.clone()) == found, "{frame:?} {format:?}");
        }
    }
}

#[test]
fn placed_textures_match_cpu() {
    const COUNT: usize = 2000;
    let gpu = kit::gpu();
    let scene = generate(GeneratedKind::City, 3);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    for frame in [FrameChoice::Light, FrameChoice::ObliqueAt(0.4)] {
        let options = BakeOptions::new(sun, Size::Resolution(512)).with(|o| o.frame = frame);
        let file = Bake::with_options(&scene, &options).in_memory().unwrap();
        for (place, placement) in placements() {
            let texture =
                LookUpTexture::new(&file, &LookUp { placement, ..LookUp::default() }, 2048).unwrap();
            let anchor = texture.anchor_world();
            let sampler = file.sampler(Filter::Box5).placed(&placement);
            let mut random = Random::for_batch(31, 0);
            let points: Vec<shade::Point> = (0..COUNT)
                .map(|i| {
                    let p_grid = file.grid.size.map(|n| f64::from(n) * (1.1 * random.unit() - 0.05));
                    let p_world = placement.to_world(file.grid.to_world(p_grid));
                    let [x, y, z] = [0, 1, 2].map(|a| (p_world[a] - f64::from(anchor[a])) as f32);
                    let up = placement.direction_to_world([0.0, 1.0, 0.0]).map(|c| c as f32);
                    let [nx, ny, nz] = if i % 2 == 0 { up } else { [0.0; 3] };
                    [[x, y, z, 0.0], [nx, ny, nz, 0.0]]
                })
                .collect();
            let found = answers(&gpu, &texture, TexelFormat::R32Uint, &points);
            let expected = points.iter().map(|[p, n]| {
                let p_world = [0, 1, 2].map(|a| f64::from(anchor[a]) + f64::from(p[a]));
                let normal = [n[0], n[1], n[2]].map(f64::from);
                sampler.visibility(p_world, (normal != [0.0; 3]).then_some(normal))
            });
            let off =
                expected.zip(&found).filter(|(expected, found)| (expected - *found).abs() > 1e-5).count();
            assert!(off * 500 <= COUNT, "{frame:?}, {place}: {off} of {COUNT} points differ");
            let partly = found.iter().filter(|v| **v > 0.0 && **v < 1.0).count();
            assert!(partly * 100 > COUNT, "{frame:?}, {place}: {partly} points are partly lit");
        }
    }
}
