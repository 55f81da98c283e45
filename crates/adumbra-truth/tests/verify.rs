//! Tests of `verify` itself: whether it draws its points uniformly, omits none, and finds each kind of wrong
//! answer.

use std::sync::atomic::AtomicBool;

use adumbra::query::{Receiver, receiver};
use adumbra::{Filter, Sampler as FileSampler, ShadowFile, Sun};
use adumbra_bake::{AssumeGround, Bake, BakeOptions, Size};
use adumbra_scene::{GeneratedKind, Instance, Scene, generate};
use adumbra_testing::{cuboid, scene_of};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{
    Answers, Class, LightAnswers, Replaced, Sampler, Solids, SurfaceSampler, Verification, Verifier,
    VerifyOptions,
};

fn bake_quietly(scene: &Scene, options: &BakeOptions) -> ShadowFile {
    Bake::with_options(scene, options).in_memory().expect("a small bake fits")
}

fn check(scene: &Scene, sun: Sun, answers: &impl Answers, samples: u64) -> Verification {
    let tracer = Tracer::build(scene, TraceOptions::default());
    let solids = Solids::of(scene);
    let sampler = Sampler::Surface(SurfaceSampler::new(scene, &solids, sun.towards(), false));
    Verifier::new(answers, &tracer, &solids).run(&sampler, &VerifyOptions { samples, seed: 5 })
}

fn verify(scene: &Scene, baked: &ShadowFile, filter: u32, samples: u64) -> Verification {
    let filter = Filter::try_from(filter).expect("a filter");
    check(scene, baked.grid.sun, &LightAnswers::of(baked, baked.sampler(filter)), samples)
}

fn placed(scale: [f64; 3], at: [f64; 3]) -> Instance {
    let row = |a: usize| {
        std::array::from_fn(|b| {
            if b == 3 {
                at[a]
            } else if a == b {
                scale[a]
            } else {
                0.0
            }
        })
    };
    Instance { name: String::new(), mesh: 0, world_from_mesh: [row(0), row(1), row(2)], casts: true }
}

/// Returns a scene of instances of a cube with a side of one metre about the origin.
fn cubes(instances: Vec<Instance>) -> Scene {
    Scene { instances, ..scene_of(vec![cuboid([-0.5; 3], [0.5; 3])]) }
}

/// A floor of 100 m by 100 m, which is the unit cube scaled non-uniformly, below a hundred cubes that float
/// three metres above it.
fn cubes_over_a_scaled_floor() -> Scene {
    let mut instances = vec![placed([100.0, 0.1, 100.0], [0.0, -0.05, 0.0])];
    for i in 0..100 {
        let at = [f64::from(i % 10) * 9.0 - 40.5, 3.0, f64::from(i / 10) * 9.0 - 40.5];
        instances.push(placed([1.0; 3], at));
    }
    cubes(instances)
}

#[test]
fn points_are_uniform_by_area_over_instances_of_any_scale() {
    let scene = cubes_over_a_scaled_floor();
    let sun = Sun::from_angles(0.0, 90.0).expect("overhead");
    let baked = bake_quietly(&scene, &BakeOptions::new(sun, Size::Resolution(1024)));
    let samples = 100_000;
    let v = verify(&scene, &baked, 1, samples);
    // The floor has 20,000 m² and 40 m² of rim, each cube 6 m². The sun sees the top faces of the floor and
    // the cubes.
    let seen = (10_000.0 + 100.0) / (20_040.0 + 600.0);
    let compared = v.samples as f64 / samples as f64;
    assert!((compared - seen).abs() < 0.006, "{compared} of the points are compared, by area {seen}");
    let shadowed = 100.0 / 10_100.0;
    assert!(
        (v.shadowed_share - shadowed).abs() < 0.002,
        "{} are shadowed, truly {shadowed}",
        v.shadowed_share
    );
    assert!(v.holds(), "{v:?}");
}

#[test]
fn instances_without_volume_are_sampled_too() {
    // The floor has no thickness, but the cube above it does.
    let scene = cubes(vec![placed([20.0, 0.0, 20.0], [0.0; 3]), placed([2.0; 3], [0.0, 4.0, 0.0])]);
    let sun = Sun::from_angles(0.0, 90.0).expect("overhead");
    let baked = bake_quietly(&scene, &BakeOptions::new(sun, Size::Resolution(512)));
    let v = verify(&scene, &baked, 1, 40_000);
    // Points are on the floor's upper and lower sides; 4 m² of 400 m² are shadowed.
    assert!(v.samples > 18_000 && (0.007..0.013).contains(&v.shadowed_share), "{v:?}");
}

#[test]
fn every_point_that_the_sun_can_shine_on_is_in_one_class() {
    let scene = generate(GeneratedKind::City, 1);
    let sun = Sun::from_angles(37.0, 4.0).expect("above the horizon");
    let baked = bake_quietly(&scene, &BakeOptions::new(sun, Size::Resolution(2048)));
    let samples = 30_000;
    let v = verify(&scene, &baked, 1, samples);
    assert_eq!(v.samples + v.facing_away + v.inside_solids + v.outside_bounds, samples);
    assert_eq!(v.classes.iter().map(|c| c.points).sum::<u64>(), v.samples);
    // Level ground under a sun at 4° elevation.
    assert!(v.class(Class::Grazing).points > 1_000, "{v:?}");
    assert!(v.class(Class::Edge).points > 100 && v.class(Class::Narrow).points > 10, "{v:?}");
    assert!(v.holds(), "{v:?}");
}

/// Falsifies an answer, given the point's grid position, its n·l and the filtered value.
type Lie = fn([f64; 3], f64, f32) -> f32;

/// Verifies a correct file of a small city whose answers are shifted and falsified, and returns the classes
/// that miss their promises.
fn caught(filter: u32, shift_texels: f64, lie: Lie) -> Vec<Class> {
    let scene = generate(GeneratedKind::City, 2);
    let sun = Sun::from_angles(37.0, 5.0).expect("above the horizon");
    let baked = bake_quietly(&scene, &BakeOptions::new(sun, Size::Resolution(2048)));
    caught_in(&scene, &baked, 20_000, filter, shift_texels, lie)
}

/// Does the same with the correct file of any scene, at this many points.
fn caught_in(
    scene: &Scene,
    baked: &ShadowFile,
    samples: u64,
    filter: u32,
    shift_texels: f64,
    lie: Lie,
) -> Vec<Class> {
    let filter = Filter::try_from(filter).expect("a filter");
    let honest = LightAnswers::of(baked, baked.sampler(filter));
    let grid = &baked.grid;
    let visibility = |honest: &LightAnswers<FileSampler>, p_world, normal: Option<[f64; 3]>| {
        let p_grid = grid.to_grid(p_world);
        let moved = grid.to_world([p_grid[0] + shift_texels, p_grid[1], p_grid[2]]);
        let n_dot_l = normal.map_or(1.0, |n| (0..3).map(|a| n[a] * honest.towards_sun()[a]).sum());
        lie(p_grid, n_dot_l, honest.visibility(moved, normal))
    };
    let liar = Replaced { answers: honest, visibility, covers: Answers::covers };
    let v = check(scene, grid.sun, &liar, samples);
    v.classes.iter().filter(|c| !c.holds).map(|c| c.class).collect()
}

#[test]
fn detects_clamped_plane_slopes_under_a_low_sun() {
    let scene = cubes_over_a_scaled_floor();
    for (elevation, filter, is_right) in [(6.0, 9, true), (3.0, 9, false), (2.0, 5, false), (2.0, 9, false)] {
        let sun = Sun::from_angles(37.0, elevation).expect("above the horizon");
        // Without assumed ground, the columns of the floor switch to shadow below it.
        let options =
            BakeOptions::new(sun, Size::Resolution(1024)).with(|o| o.assume_ground = AssumeGround::No);
        let baked = bake_quietly(&scene, &options);
        let query = baked.sampler(Filter::try_from(filter).expect("a filter"));
        let honest = || LightAnswers::of(&baked, query.clone());
        let v = check(&scene, sun, &honest(), 10_000);
        assert!(
            v.holds() && (is_right || v.class(Class::Grazing).points > 1_000),
            "{elevation}° {filter}: {v:?}"
        );
        // Repeats the look-ups with the slope of their plane clamped to 9.95.
        let clamped = |honest: &LightAnswers<FileSampler>, p_world, normal| {
            let r = receiver(&baked.grid, &honest.bias(), p_world, normal);
            let slope = r.gradient[0].hypot(r.gradient[1]);
            let gradient = r.gradient.map(|g| g * (9.95 / slope).min(1.0));
            query.receiver_visibility(&Receiver { gradient, ..r })
        };
        let v = check(
            &scene,
            sun,
            &Replaced { answers: honest(), visibility: clamped, covers: Answers::covers },
            10_000,
        );
        assert_eq!(v.class(Class::Grazing).holds, is_right, "{elevation}° {filter}: {v:?}");
    }
}

/// Whether a point belongs to one percent of the points, spread over the grid.
fn is_one_of_a_hundred(p_grid: [f64; 3]) -> bool {
    (p_grid[0] * 7.3 + p_grid[1] * 3.1).rem_euclid(1.0) < 0.01
}

#[test]
fn right_answers_keep_every_promise() {
    assert_eq!(caught(1, 0.0, |_, _, value| value), []);
    assert_eq!(caught(5, 0.0, |_, _, value| value), []);
    assert_eq!(caught(9, 0.0, |_, _, value| value), []);
}

#[test]
fn detects_one_percent_of_wrong_answers_in_the_interior() {
    let lie: Lie = |p, _, value| if is_one_of_a_hundred(p) { 1.0 - value } else { value };
    assert!(caught(1, 0.0, lie).contains(&Class::Interior));
}

#[test]
fn detects_wrong_answers_under_a_grazing_sun() {
    let lie: Lie = |p, n_dot_l, value| {
        if n_dot_l <= 0.1 && (p[0] * 0.37).rem_euclid(1.0) < 0.03 { 1.0 - value } else { value }
    };
    assert!(caught(1, 0.0, lie).contains(&Class::Grazing));
}

#[test]
fn detects_shadows_shifted_by_half_a_texel() {
    let found = caught(1, 0.5, |_, _, value| value);
    assert!(found.contains(&Class::Edge), "{found:?}");
}

#[test]
fn detects_filtered_values_that_are_slightly_too_dark() {
    let found = caught(9, 0.0, |_, _, value| value * 0.95);
    assert!(found.contains(&Class::Interior), "{found:?}");
}

#[test]
fn detects_unfiltered_answers_in_place_of_filtered_ones() {
    let found = caught(9, 0.0, |_, _, value| if value > 0.5 { 1.0 } else { 0.0 });
    assert!(found.contains(&Class::Edge), "{found:?}");
}

/// A floor with rows of posts, each two texels wide at a resolution of 1024.
fn posts_on_a_floor() -> Scene {
    let mut instances = vec![placed([100.0, 0.1, 100.0], [0.0, -0.05, 0.0])];
    for i in 0..400 {
        let at = [f64::from(i % 20) * 4.7 - 44.0, 1.5, f64::from(i / 20) * 4.7 - 44.0];
        instances.push(placed([0.2, 3.0, 0.2], at));
    }
    cubes(instances)
}

#[test]
fn detects_missing_shadows_of_posts() {
    let scene = posts_on_a_floor();
    let sun = Sun::from_angles(37.0, 40.0).expect("above the horizon");
    let floor = cubes(vec![scene.instances[0].clone()]);
    let options = BakeOptions::new(sun, Size::Resolution(1024));
    for filter in [1, 5, 9] {
        let right = verify(&scene, &bake_quietly(&scene, &options), filter, 20_000);
        assert!(right.holds() && right.class(Class::Narrow).checked, "{filter}: {right:?}");
        let bare = verify(&scene, &bake_quietly(&floor, &options), filter, 20_000);
        assert!(!bare.class(Class::Narrow).holds, "{filter}: {bare:?}");
    }
}

#[test]
fn nan_counts_as_a_wrong_answer() {
    let found = caught(9, 0.0, |_, _, _| f32::NAN);
    assert!(found.contains(&Class::Interior), "{found:?}");
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn values_outside_0_to_1_count_as_wrong() {
    no_visibility_is_caught(|filter, lie| caught(filter, 0.0, lie));
}

#[test]
fn values_outside_0_to_1_count_as_wrong_below_cubes() {
    let scene = cubes_over_a_scaled_floor();
    let sun = Sun::from_angles(37.0, 40.0).expect("above the horizon");
    let baked = bake_quietly(&scene, &BakeOptions::new(sun, Size::Resolution(512)));
    no_visibility_is_caught(|filter, lie| caught_in(&scene, &baked, 2_000, filter, 0.0, lie));
}

fn no_visibility_is_caught(caught: impl Fn(u32, Lie) -> Vec<Class>) {
    for filter in [1, 9] {
        let lies: [(f32, Lie); 3] = [
            (f32::NAN, |_, _, _| f32::NAN),
            (f32::INFINITY, |_, _, _| f32::INFINITY),
            (-0.25, |_, _, _| -0.25),
        ];
        for (value, lie) in lies {
            let found = caught(filter, lie);
            assert!(found.contains(&Class::Interior), "{filter}, {value}: {found:?}");
        }
    }
}

#[test]
fn too_few_points_do_not_pass_verification() {
    let scene = posts_on_a_floor();
    let sun = Sun::from_angles(37.0, 40.0).expect("above the horizon");
    let baked = bake_quietly(&scene, &BakeOptions::new(sun, Size::Resolution(1024)));
    let few = verify(&scene, &baked, 1, 300);
    let interior = few.class(Class::Interior);
    assert!(interior.points > 50 && interior.agreement == 1.0 && !interior.checked, "{few:?}");
    assert!(!few.holds());
    assert!(verify(&scene, &baked, 1, 3_000).holds());
}

#[test]
fn cancelled_comparison_compares_nothing_more() {
    let scene = posts_on_a_floor();
    let sun = Sun::from_angles(37.0, 40.0).expect("above the horizon");
    let baked = bake_quietly(&scene, &BakeOptions::new(sun, Size::Resolution(256)));
    let (tracer, solids) = (Tracer::build(&scene, TraceOptions::default()), Solids::of(&scene));
    let sampler = Sampler::Surface(SurfaceSampler::new(&scene, &solids, sun.towards(), false));
    let answers = LightAnswers::of(&baked, baked.sampler(Filter::Nearest));
    for is_cancelled in [false, true] {
        let cancel = AtomicBool::new(is_cancelled);
        let verifier = Verifier::new(&answers, &tracer, &solids).with_cancel(&cancel);
        let found = verifier.run(&sampler, &VerifyOptions { samples: 5_000, seed: 5 });
        assert_eq!(found.samples == 0, is_cancelled, "{found:?}");
    }
}
