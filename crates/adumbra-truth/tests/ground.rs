//! Ground that only an app draws: shadows on it, and whether `verify` looks at it.

use adumbra::{Bounds, FileSettings, Filter, ShadowFile, Sun};
use adumbra_bake::{AssumeGround, BakeOptions, FrameChoice, Size};
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_testing::bake_file;
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
    bake_file(scene, options).expect("a small bake fits")
}

/// Verifies a file as if its settings were these.
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
fn buildings_alone_cast_on_the_ground_that_an_app_draws() {
    let scene = without_ground(GeneratedKind::City);
    for (azimuth, elevation, frame) in [
        (0.0, 35.0, FrameChoice::Light),
        (205.0, 50.0, FrameChoice::Oblique),
        (70.0, 17.0, FrameChoice::Auto),
    ] {
        let sun = Sun::from_angles(azimuth, elevation).expect("above the horizon");
        let options = BakeOptions { frame, ..BakeOptions::new(sun, Size::Resolution(1024)) };
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
fn shadows_that_are_left_out_below_the_last_surface_are_missed() {
    let scene = without_ground(GeneratedKind::City);
    let sun = Sun::from_angles(205.0, 50.0).expect("above the horizon");
    let options =
        BakeOptions { assume_ground: AssumeGround::Yes, ..BakeOptions::new(sun, Size::Resolution(1024)) };
    let file = baked(&scene, &options);
    // Such a file promises nothing there.
    let v = verify(&scene, &file, file.settings, 1);
    assert_eq!((v.class(Class::Ground).points, v.class(Class::Ground).promised_agreement), (0, None));
    let v = verify(&scene, &file, FileSettings { assume_ground: false, ..file.settings }, 1);
    let ground = v.class(Class::Ground);
    assert!(!ground.holds && ground.leak > 10, "{ground:?}");
}

#[test]
fn ground_far_behind_the_grid_is_in_shadow() {
    // A wall whose shadow is much longer than the grid is deep, and one that bounds cut off.
    let scene = without_ground(GeneratedKind::Primitives);
    let sun = Sun::from_angles(30.0, 12.0).expect("above the horizon");
    let all = scene.bounds();
    let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * (all.min[a] + all.max[a]));
    for bounds in [None, Some(Bounds { min: all.min, max: middle })] {
        let options = BakeOptions { bounds, ..BakeOptions::new(sun, Size::Resolution(512)) };
        let file = baked(&scene, &options);
        let v = verify(&scene, &file, file.settings, 1);
        let ground = v.class(Class::Ground);
        assert!(ground.holds && ground.checked, "{bounds:?}: {ground:?}");
    }
}
