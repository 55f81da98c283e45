//! Penumbrae from baked switch depths compared with rays to a sun's disc, on shared scenes.

use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_compare::truth::{StreetOptions, SunShape, TruthTracer, street_camera, truth_camera};
use adumbra_render::{
    Answer, Gpu, GpuOptions, Renderer, SceneOptions, Shot, TechniqueFiles, TechniqueSpec, build,
};
use adumbra_scene::{Camera, LoadOptions, load};
use adumbra_testing::{full, scene_file, shared};

/// Compares RMSE over the pixels that face the sun, at street level, under a sun of two degrees.
#[test]
#[ignore = "slow: a real scene; in pictures of full size with ADUMBRA_FULL"]
fn shared_soft_voxels_beat_fixed_filters_on_a_sun_disc() {
    let (Some(scenes), Some(truths)) = (shared("scenes"), shared("truth")) else { return };
    let name = "kaykit_city_21";
    let scene = load(&scene_file(&scenes, name), &LoadOptions::default()).unwrap();
    let (camera, sun) = truth_camera(&truths.join(format!("{name}.npz"))).unwrap();
    let truth = TruthTracer::build(&scene, false);
    let street = street_camera(&truth, sun.towards(), &StreetOptions::default()).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(8192)).with(|o| o.thickness_world = 0.1);
    let baked = Bake::with_options(&scene, &options).in_memory().unwrap();
    let gpu = Gpu::request(&GpuOptions::default()).unwrap();
    let mut renderer = Renderer::new(gpu, &scene, SceneOptions::default()).unwrap();
    for (view, camera) in [("afar", camera), ("street", street)] {
        let [width, height] = if full() { [480, 270] } else { [240, 135] };
        let camera = Camera { width, height, ..camera };
        let surfaces = truth.surfaces(&camera);
        let disc = SunShape::Disc { sun_degrees: 2.0, samples: 64 };
        let expected = truth.factors(&surfaces, sun.towards(), disc);
        let facing: Vec<usize> = (0..surfaces.pixels())
            .filter(|&i| surfaces.is_valid(i) && surfaces.n_dot_l(i, sun.towards()) > 0.1)
            .collect();
        let shot = Shot { camera, towards_sun: sun.towards(), number: 0 };
        let mut error = |name: &str| {
            let spec: TechniqueSpec = name.parse().unwrap();
            let technique = build(renderer.gpu(), &spec, TechniqueFiles::of(&baked)).unwrap();
            let mut technique = renderer.prepare(technique).unwrap();
            renderer.draw(&shot, &mut technique, Answer::Visibility).unwrap();
            let factors = renderer.read_factor(&technique).unwrap();
            let squares: f64 = facing.iter().map(|&i| f64::from(factors[i] - expected[i]).powi(2)).sum();
            let rmse = (squares / facing.len() as f64).sqrt();
            println!("{view} {name:30} {rmse:.4}");
            rmse
        };
        let soft = error("voxel:soft:sun-degrees=2:radius=64");
        error("pcss:sun-degrees=2:size=8192");
        for width in [1, 3, 5, 9, 17] {
            assert!(soft < error(&format!("voxel:filter={width}")), "{view}, {width}");
        }
    }
}
