//! Ground that only an app draws: shadows on it, and whether `verify` checks them.

use adumbra::{Bounds, FileSettings, Filter, ShadowFile, Sun};
use adumbra_bake::{AssumeGround, Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, Mesh, Scene, generate};
use adumbra_testing::{add_box, scene_of};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{
    Class, LightAnswers, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions,
};

/// A generated scene without its ground.
fn without_ground(kind: GeneratedKind) -> Scene {
    let mut scene = generate(kind, 1);
    let Scene { instances, meshes, .. } = &mut scene;
    instances.retain(|i| meshes[i.mesh as usize].name != "ground");
    scene
}

fn baked(scene: &Scene, options: &BakeOptions) -> ShadowFile {
    Bake::with_options(scene, options).in_memory().expect("a small bake fits")
}

/// Verifies a file with these settings in place of its own.
fn verify(scene: &Scene, file: &ShadowFile, settings: FileSettings, filter: u32) -> Verification {
    let tracer = Tracer::build(scene, TraceOptions::default());
    let solids = Solids::of(scene);
    let sun = file.grid.sun.towards();
    let sampler = Sampler::Surface(SurfaceSampler::new(scene, &solids, sun, false));
    let look_up = file.sampler(Filter::try_from(filter).expect("a filter"));
    let asked = (look_up.filter(), look_up.bias());
    let answers = LightAnswers::new(file.grid, settings, look_up, asked);
    let options = VerifyOptions { samples: 40_000, seed: 3 };
    Verifier::new(&answers, &tracer, &solids).with_ground().run(&sampler, &options)
}

#[test]
fn scene_without_ground_casts_on_the_ground_of_an_app() {
    let scene = without_ground(GeneratedKind::City);
    for (azimuth, elevation, frame) in [
        (0.0, 35.0, FrameChoice::Light),
        (205.0, 50.0, FrameChoice::Oblique),
        (70.0, 17.0, FrameChoice::Auto),
    ] {
        let sun = Sun::from_angles(azimuth, elevation).expect("above the horizon");
        let options = BakeOptions::new(sun, Size::Resolution(1024)).with(|o| o.frame = frame);
        let file = baked(&scene, &options);
        assert!(!file.settings.assume_ground);
        for filter in [1, 5] {
            let v = verify(&scene, &file, file.settings, filter);
            let ground = v.class(Class::Ground);
            assert!(ground.checked && ground.holds, "{azimuth}° {elevation}° {filter}: {ground:?}");
            assert!(v.class(Class::Edge).holds, "{azimuth}° {elevation}° {filter}: {v:?}");
        }
    }
}

#[test]
fn verify_detects_missing_shadows_below_the_last_surface() {
    let scene = without_ground(GeneratedKind::City);
    let sun = Sun::from_angles(205.0, 50.0).expect("above the horizon");
    let options = BakeOptions::new(sun, Size::Resolution(1024)).with(|o| o.assume_ground = AssumeGround::Yes);
    let file = baked(&scene, &options);
    // A file that assumes ground promises nothing below it.
    let v = verify(&scene, &file, file.settings, 1);
    assert_eq!((v.class(Class::Ground).points, v.class(Class::Ground).promised_agreement), (0, None));
    let v = verify(&scene, &file, FileSettings { assume_ground: false, ..file.settings }, 1);
    let ground = v.class(Class::Ground);
    assert!(!ground.holds && ground.leak > 10, "{ground:?}");
}

#[test]
fn ground_far_beyond_the_grid_is_in_shadow() {
    // A wall whose shadow is much longer than the grid is deep, and one that bounds cut off.
    let scene = without_ground(GeneratedKind::Primitives);
    let sun = Sun::from_angles(30.0, 12.0).expect("above the horizon");
    let all = scene.bounds();
    let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * (all.min[a] + all.max[a]));
    for bounds in [None, Some(Bounds { min: all.min, max: middle })] {
        let options = BakeOptions::new(sun, Size::Resolution(512)).with(|o| o.bounds = bounds);
        let file = baked(&scene, &options);
        let v = verify(&scene, &file, file.settings, 1);
        let ground = v.class(Class::Ground);
        assert!(ground.holds && ground.checked, "{bounds:?}: {ground:?}");
    }
}

/// A column whose centre is inside the wall may switch anywhere from the wall's roof to its foot. Geometry
/// behind the wall may move the switch down.
#[test]
fn points_below_a_ledge_beside_a_wall_are_dark_at_noon() {
    let mut town = Mesh::default();
    let walls = (0..16_u8).map(|n| 10.0 * f32::from(n) + 0.031 * f32::from(n)).collect::<Vec<_>>();
    for &x in &walls {
        add_box(&mut town, [x, 0.0, 0.0], [x + 1.5, 15.0, 20.0]);
        add_box(&mut town, [x + 1.5, 0.0, 0.0], [x + 5.0, 2.0, 20.0]);
        add_box(&mut town, [x - 1.5, 9.0, 1.0], [x + 0.5, 9.4, 19.0]);
    }
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).expect("above the horizon");
    let file = baked(&scene_of(vec![town]), &BakeOptions::new(sun, Size::VoxelSize(0.125)));
    assert!(!file.settings.assume_ground);
    let look_up = file.sampler(Filter::Nearest);
    let mut random = Random::new(7, 0);
    for x in walls.iter().map(|&x| f64::from(x)) {
        for _ in 0..500 {
            let [beside, y, z] = [(0.001, 0.06), (0.1, 8.7), (1.5, 18.5)]
                .map(|(low, high): (f64, f64)| low + (high - low) * random.unit());
            let p_world = [x - beside, y, z];
            assert_eq!(look_up.visibility(p_world, None), 0.0, "{p_world:?}");
        }
    }
}
