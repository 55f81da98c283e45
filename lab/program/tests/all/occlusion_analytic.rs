//! Ambient occlusion compared with exact integrals: a plane, the inside corner of two planes, a sphere on a
//! plane.
//!
//! Visibility is cosine-weighted, within a radius R. Seen from above the surface, cosine-weighted directions
//! fill the unit disc evenly, so visibility is the share of the disc whose rays hit nothing within R.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use adumbra_compare::truth::{Cache, Surfaces, TruthTracer, scene_key};
use adumbra_lab::occlusion::{OcclusionReference, OcclusionStage, path_flicker, scene_named};
use adumbra_render::occlusion::{Estimator, Filter, OcclusionPasses, OcclusionSettings};
use adumbra_render::{Gpu, GpuOptions, SceneOptions};
use adumbra_scene::{Camera, Mesh, Projection, Scene};
use adumbra_testing::{add_quad, scene_of};

const SIZE: [u32; 2] = [288, 162];
/// Width in pixels of the picture's border that is ignored.
const RIM: u32 = 24;
/// Largest error of the truth at any pixel. Its mean error may be a fifth of this.
const TRUTH_TOLERANCE: f64 = 0.03;
const TOLERANCE: f64 = 0.10;
/// Largest deviation of a plane's mean visibility from 1.
const PLANE_TOLERANCE: f64 = 0.01;
const RAYS: u32 = 1024;
/// One in this many of the pixels with an integral is traced.
const TRACED: usize = 7;

/// Returns a square of ground around the origin.
fn ground(side: f32) -> Mesh {
    let s = 0.5 * side;
    let mut mesh = Mesh::default();
    add_quad(&mut mesh, [[-s, 0.0, s], [s, 0.0, s], [s, 0.0, -s], [-s, 0.0, -s]]);
    mesh
}

fn add_sphere(mesh: &mut Mesh, center: [f64; 3], radius: f64, rings: u32) {
    let point = |ring: u32, step: u32| -> [f32; 3] {
        let (polar, around) =
            (PI * f64::from(ring) / f64::from(rings), PI * f64::from(step) / f64::from(rings));
        let [x, y, z] = [polar.sin() * around.cos(), polar.cos(), -polar.sin() * around.sin()];
        [(0, x), (1, y), (2, z)].map(|(a, c): (usize, f64)| (center[a] + radius * c) as f32)
    };
    for (ring, step) in (0..rings).flat_map(|r| (0..2 * rings).map(move |s| (r, s))) {
        let [a, b] = [ring, ring + 1];
        add_quad(mesh, [point(a, step), point(b, step), point(b, step + 1), point(a, step + 1)]);
    }
}

fn camera(eye: [f64; 3], target: [f64; 3], fov_degrees: f64) -> Camera {
    let projection = Projection::Perspective { fov_degrees };
    Camera { eye, target, projection, width: SIZE[0], height: SIZE[1] }
}

fn stage(scene: &Scene, camera: Camera) -> OcclusionStage {
    let gpu = Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    OcclusionStage::new(gpu, scene, SceneOptions::default(), camera).unwrap()
}

fn visibility(stage: &OcclusionStage, settings: OcclusionSettings) -> Vec<f32> {
    stage.visibility(&mut OcclusionPasses::new(stage.gpu(), settings)).unwrap()
}

fn unfiltered(mut settings: OcclusionSettings) -> OcclusionSettings {
    settings.filter = Filter::None;
    settings
}

/// Returns whether a pixel is away from the picture's border.
fn inside(i: usize) -> bool {
    let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
    let within = |c: u32, size: u32| c >= RIM && c < size - RIM;
    within(x, SIZE[0]) && within(y, SIZE[1])
}

/// Compares truth and every estimator with `integral`.
///
/// `integral` returns the visibility of a point with its normal, or `None` if the point is not to be
/// compared.
fn check(
    name: &str,
    scene: &Scene,
    camera: Camera,
    radius_world: f64,
    integral: impl Fn([f64; 3], [f64; 3]) -> Option<f64>,
) {
    let truth = TruthTracer::build(scene, false);
    let seen = truth.surfaces(&camera);
    let right: Vec<(usize, f64)> = (0..seen.pixels())
        .filter(|&i| inside(i) && seen.is_valid(i))
        .filter_map(|i| integral(seen.position[i], seen.normal[i].map(f64::from)).map(|v| (i, v)))
        .collect();
    assert!(right.len() > 2000, "{name}: {} pixels", right.len());
    let darkest = right.iter().map(|r| r.1).fold(1.0, f64::min);
    assert!(darkest < 0.6, "{name}: the region goes to {darkest}");

    let some: Vec<(usize, f64)> = right.iter().copied().step_by(TRACED).collect();
    let surfaces = Surfaces {
        width: some.len() as u32,
        height: 1,
        position: some.iter().map(|&(i, _)| seen.position[i]).collect(),
        normal: some.iter().map(|&(i, _)| seen.normal[i]).collect(),
        view_depth: vec![1.0; some.len()],
        lift_world: some.iter().map(|&(i, _)| seen.lift_world[i]).collect(),
    };
    let traced = truth.ambient(&surfaces, radius_world, RAYS);
    let off = some.iter().zip(&traced).map(|((_, right), v)| (f64::from(*v) - right).abs());
    let (worst, mean) = (off.clone().fold(0.0, f64::max), off.sum::<f64>() / some.len() as f64);
    println!("{name}: truth off by {mean:.4}, at most {worst:.4}");
    assert!(mean < 0.2 * TRUTH_TOLERANCE && worst < TRUTH_TOLERANCE, "{name}: {mean} {worst}");

    let stage = stage(scene, camera);
    let off = Estimator::ALL.map(|estimator| {
        let found = visibility(&stage, OcclusionSettings::new(estimator, radius_world));
        let sum = right.iter().map(|&(i, v)| (f64::from(found[i]) - v).abs()).sum::<f64>();
        (estimator.name(), sum / right.len() as f64)
    });
    println!("{name}: {off:.4?}");
    assert!(off.iter().all(|(_, mean)| *mean < TOLERANCE), "{name}: {off:.4?}");
}

#[test]
fn occlusion_of_infinite_plane_is_zero() {
    let scene = scene_of(vec![ground(4000.0)]);
    for (name, eye) in [("steep", [0.0, 10.0, 6.0]), ("grazing", [0.0, 0.6, 14.0]), ("low", [0.0, 0.15, 8.0])]
    {
        let stage = stage(&scene, camera(eye, [0.0, 0.0, 0.0], 40.0));
        let surface = stage.surface().unwrap();
        let pixels =
            || (0..surface.view_depth.len()).filter(|&i| inside(i) && surface.view_depth[i].is_finite());
        for (estimator, filtered) in Estimator::ALL.iter().flat_map(|e| [(*e, true), (*e, false)]) {
            let settings = OcclusionSettings::new(estimator, 1.0);
            let found = visibility(&stage, if filtered { settings } else { unfiltered(settings) });
            let mean = pixels().map(|i| f64::from(found[i])).sum::<f64>() / pixels().count() as f64;
            println!("{name}: {estimator}, filtered {filtered}: {mean:.4}");
            assert!(
                (mean - 1.0).abs() <= PLANE_TOLERANCE,
                "{name}: {estimator}, filtered {filtered}: {mean}"
            );
        }
    }
}

/// Returns the share of the disc that a wall occludes.
///
/// A ray hits a plane that is `distance` away after distance / (the direction's component towards it). That
/// is within R if the component is at least distance / R. The directions that hit are therefore the disc's
/// segment beyond a chord.
fn wall(distance: f64, radius: f64) -> f64 {
    let chord = (distance / radius).min(1.0);
    (chord.acos() - chord * (1.0 - chord * chord).sqrt()) / PI
}

#[test]
fn occlusion_in_inside_corner_matches_integral() {
    let mut corner = ground(200.0);
    add_quad(&mut corner, [[-100.0, 0.0, 0.0], [100.0, 0.0, 0.0], [100.0, 100.0, 0.0], [-100.0, 100.0, 0.0]]);
    let radius = 1.0;
    let view = camera([0.8, 2.4, 5.2], [0.0, 0.5, 0.3], 40.0);
    check("corner", &scene_of(vec![corner]), view, radius, |p, n| {
        let distance = if n[1] > 0.5 { p[2] } else { p[1] };
        (distance < radius).then(|| 1.0 - wall(distance, radius))
    });
}

/// Returns the visibility of the ground at `distance` from the point where a sphere of radius `a` touches it.
///
/// It is found numerically over cells of the disc.
fn beside_sphere(distance: f64, a: f64, radius: f64) -> f64 {
    const RINGS: u32 = 96;
    const STEPS: u32 = 192;
    let mut met = 0_u32;
    for (ring, step) in (0..RINGS).flat_map(|r| (0..STEPS).map(move |s| (r, s))) {
        // The rings have equal area.
        let r = ((f64::from(ring) + 0.5) / f64::from(RINGS)).sqrt();
        let around = TAU * (f64::from(step) + 0.5) / f64::from(STEPS);
        let d = [r * around.cos(), (1.0 - r * r).sqrt(), r * around.sin()];
        // A ray from (distance, 0, 0) to the sphere around (0, a, 0), with c the vector to its centre:
        // t² - 2 t (c·d) + c·c - a² = 0.
        let along = -distance * d[0] + a * d[1];
        let discriminant = along * along - distance * distance;
        met += u32::from(along > 0.0 && discriminant >= 0.0 && along - discriminant.sqrt() <= radius);
    }
    1.0 - f64::from(met) / f64::from(RINGS * STEPS)
}

#[test]
fn occlusion_beside_sphere_matches_integral() {
    let (a, radius) = (1.0, 1.0);
    let mut mesh = ground(200.0);
    add_sphere(&mut mesh, [0.0, a, 0.0], a, 96);
    let scene = scene_of(vec![mesh]);
    // Visibility by distance from the point where the sphere touches the ground.
    let known: Vec<f64> = (0..=200).map(|i| beside_sphere(f64::from(i) * 0.01, a, radius)).collect();
    let at = |distance: f64| {
        let place = distance * 100.0;
        let share = place.fract();
        known[place as usize] * (1.0 - share) + known[place as usize + 1] * share
    };
    assert!(at(0.02) < 0.05 && at(1.9) > 0.99, "{} {}", at(0.02), at(1.9));
    check("sphere", &scene, camera([0.0, 2.6, 5.4], [0.0, 0.55, 0.0], 40.0), radius, |p, n| {
        let distance = p[0].hypot(p[2]);
        (n[1] > 0.999 && p[1].abs() < 1e-3 && distance < 1.8).then(|| at(distance))
    });
}

#[test]
fn filter_reduces_error_and_flicker_in_cornell_box() {
    let view = scene_named("cornell").unwrap().open(Path::new("")).unwrap();
    let (truth, key, cache) =
        (TruthTracer::build(&view.scene, false), scene_key(&view.scene, false), Cache::none());
    let radius_world = view.radius_world;
    let reference = OcclusionReference { truth: &truth, cache: &cache, scene: &key, radius_world, rays: 64 };
    let mut stage = stage(&view.scene, view.camera(SIZE));
    let compared = reference.trace_view(&stage).unwrap();
    assert!(compared.pixels.compared as f64 > 0.95 * compared.truth.len() as f64, "{:?}", compared.pixels);
    let none = compared.errors_of_none().rmse;
    for estimator in Estimator::ALL {
        let settings = OcclusionSettings::new(estimator, radius_world);
        let [with, without] =
            [settings, unfiltered(settings)].map(|s| compared.errors(&visibility(&stage, s)).unwrap().rmse);
        println!("{estimator}: {with:.4}, without filter {without:.4}, none {none:.4}");
        assert!(with < without && with < 0.8 * none, "{estimator}: {with} {without} {none}");
    }
    // Identical cameras give no flicker. Between neighbouring cameras, the filter reduces it.
    let path = view.path(SIZE);
    let each = |path: &[Camera], stage: &mut OcclusionStage| {
        let settings = OcclusionSettings::new(Estimator::Issao, radius_world);
        let mut passes = [settings, unfiltered(settings)].map(|s| OcclusionPasses::new(stage.gpu(), s));
        path_flicker(stage, path, &mut passes)
            .unwrap()
            .into_iter()
            .map(|f| f.unwrap().mean)
            .collect::<Vec<_>>()
    };
    assert!(each(&[path[0], path[0]], &mut stage).iter().all(|f| *f < 1e-6));
    let moving = each(&path[..3], &mut stage);
    println!("flicker {moving:?}");
    assert!(moving[0] > 1e-5 && moving[0] < 0.5 * moving[1], "{moving:?}");
}
