//! Ambient occlusion: GPU against CPU.

mod kit;

use adumbra_render::frame::frame;
use adumbra_render::occlusion::twin::{Surfaces, ambient};
use adumbra_render::occlusion::{OcclusionPasses, OcclusionSettings};
use adumbra_render::readback::read_floats;
use adumbra_render::{Answer, Baked, Renderer, SceneOptions, Shot, build};

#[test]
fn occlusion_on_the_gpu_is_the_cpu_s() {
    let mut renderer = Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap();
    let none = build(renderer.gpu(), &"none".parse().unwrap(), Baked::default()).unwrap();
    let mut none = renderer.prepare(none).unwrap();
    let shot = Shot { camera: kit::camera(203, 151), towards_sun: kit::sun(), number: 0 };
    renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
    let depth = read_floats(renderer.gpu(), &renderer.targets().unwrap().depth.texture, 0, 0).unwrap();
    let normal = renderer.read_surface(&shot).unwrap().normal;
    let frame = frame(&shot.camera, &renderer.bounds(), shot.towards_sun, 0);
    let surfaces = Surfaces { frame, depth: &depth, normal: &normal };
    for text in ["issao:filter=none", "issao"] {
        let settings = OcclusionSettings::from_spec(&text.parse().unwrap(), 8.0).unwrap();
        let mut passes = OcclusionPasses::new(renderer.gpu(), settings);
        renderer.occlude(&shot, &mut passes).unwrap();
        let found = passes.read(renderer.gpu()).unwrap();
        let expected = ambient(&settings, &surfaces);
        let worst = found.iter().zip(&expected).map(|(a, b)| (a - b[0]).abs()).fold(0.0, f32::max);
        let mean = found.iter().sum::<f32>() / found.len() as f32;
        println!("{text}: {worst}, mean {mean}");
        assert!(worst < 2e-3, "{text}: {worst}");
        assert!(mean < 0.98 && mean > 0.3, "{text}: {mean}");
    }
}
