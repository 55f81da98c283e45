//! A camera's view does not depend on a scene's other content, nor on its position in the world.
//!
//! Compares pictures, shadows, ambient occlusion and errors against rays, of scenes that are wide, have a
//! stray triangle, or are at map coordinates.

use adumbra::{ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_compare::compare::Comparison;
use adumbra_render::occlusion::{Estimator, OcclusionPasses, OcclusionSettings};
use adumbra_render::{Answer, Given, Gpu, GpuOptions, Renderer, SceneOptions, Shot};
use adumbra_scene::{Camera, GeneratedKind, Mesh, Projection, Scene, generate};
use adumbra_testing::{add_box, add_quad, full, scene_of};

use crate::compared;

const SIZE: [u32; 2] = [160, 120];
const SUN: [f64; 3] = [0.5, 0.8, 0.35];

/// Returns a scene of one mesh, as from an OBJ file without object names.
///
/// It is a square ground with side 2 · `half`, boxes of 2 m on it, and the triangles `besides`.
fn ground_and_boxes(half: f32, boxes: &[[f32; 2]], besides: &[[[f32; 3]; 3]]) -> Scene {
    let mut mesh = Mesh::default();
    add_quad(&mut mesh, [[-half, 0.0, -half], [-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half]]);
    for &[x, z] in boxes {
        add_box(&mut mesh, [x - 1.0, 0.0, z - 1.0], [x + 1.0, 2.0, z + 1.0]);
    }
    for triangle in besides {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(triangle);
        mesh.triangles.push([first, first + 1, first + 2]);
        mesh.triangle_materials.push(0);
    }
    scene_of(vec![mesh])
}

fn camera(eye: [f64; 3], target: [f64; 3]) -> Camera {
    let projection = Projection::Perspective { fov_degrees: 45.0 };
    Camera { eye, target, projection, width: SIZE[0], height: SIZE[1] }
}

/// The view of a scene from a camera.
struct RenderedView {
    comparison: Comparison,
    /// Ambient visibility with a radius of one metre.
    ambient: Vec<f32>,
    picture: Vec<u8>,
    view_depth: Vec<f32>,
}

fn renderer(scene: &Scene) -> Renderer {
    let gpu = Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    Renderer::new(gpu, scene, SceneOptions::default()).unwrap()
}

fn see(scene: &Scene, file: Option<&ShadowFile>, camera: &Camera, names: &[&str]) -> RenderedView {
    let mut renderer = renderer(scene);
    let sun = file.map_or_else(|| Sun::from_direction(SUN).unwrap(), |f| f.grid.sun);
    let comparisons =
        compared::comparisons(&mut renderer, scene, file, sun, std::slice::from_ref(camera), names);
    let comparison = comparisons.into_iter().next().unwrap();
    let shot = Shot { camera: *camera, towards_sun: sun.towards(), number: 0 };
    let settings = OcclusionSettings::new(Estimator::Gtao, 1.0);
    renderer.set_ambient(Some(OcclusionPasses::new(renderer.gpu(), settings).into()));
    let lit = vec![1.0; (SIZE[0] * SIZE[1]) as usize];
    let given = Given::new(renderer.gpu(), "lit", SIZE, &lit).unwrap();
    let mut given = renderer.prepare(Box::new(given)).unwrap();
    renderer.draw(&shot, &mut given, Answer::Visibility).unwrap();
    RenderedView {
        comparison,
        ambient: renderer.read_ambient().unwrap(),
        picture: renderer.read_picture().unwrap(),
        view_depth: renderer.read_surface(&shot).unwrap().view_depth,
    }
}

/// Compares the view of a changed scene with that of the plain one, at the pixels where the plain one has a
/// surface.
fn assert_same(what: &str, plain: &RenderedView, changed: &RenderedView) {
    let surfaces: Vec<usize> =
        (0..plain.view_depth.len()).filter(|&i| plain.view_depth[i].is_finite()).collect();
    assert!(surfaces.len() > 5_000, "{what}: {} pixels", surfaces.len());
    let excluded = changed.comparison.pixels.excluded_share();
    assert!(excluded <= 0.001, "{what}: {excluded} of the pixels are excluded");
    let share = |differs: &dyn Fn(usize) -> bool| {
        surfaces.iter().filter(|&&i| differs(i)).count() as f64 / surfaces.len() as f64
    };
    let far = |a: f32, b: f32| (a - b).abs() > 1.0 / 255.0;
    let pictures = share(&|i| (4 * i..4 * i + 3).any(|k| plain.picture[k].abs_diff(changed.picture[k]) > 1));
    assert!(pictures <= 0.001, "{what}: {pictures} of the picture differ");
    let ambient = share(&|i| far(plain.ambient[i], changed.ambient[i]));
    assert!(ambient <= 0.001, "{what}: {ambient} of ambient occlusion differ");
    for (a, b) in plain.comparison.compared.iter().zip(&changed.comparison.compared) {
        let factors = share(&|i| far(a.factors[i], b.factors[i]));
        assert!(factors <= 0.001, "{what}, {}: {factors} of the factors differ", a.row.name);
        if plain.comparison.pixels.sky == changed.comparison.pixels.sky {
            let [a_wrong, b_wrong] = [a, b].map(|c| c.row.wrong().unwrap());
            assert!(
                (a_wrong - b_wrong).abs() <= 0.0005,
                "{what}, {}: {a_wrong}, {b_wrong} wrong",
                a.row.name
            );
        }
    }
}

#[test]
#[ignore = "slow: traces and draws large scenes"]
fn a_stray_triangle_changes_nothing_near_the_camera() {
    let boxes = [[0.0, 0.0], [3.0, -2.0]];
    let far = 1e6;
    let stray = [[far, 0.0, far], [far + 1.0, 0.0, far], [far, 0.0, far + 1.0]];
    let (plain, strayed) = (ground_and_boxes(20.0, &boxes, &[]), ground_and_boxes(20.0, &boxes, &[stray]));
    let street = camera([0.0, 1.5, 6.0], [0.0, 1.0, 0.0]);
    let names = ["none", "csm", "csm:filter=1", "csm:filter=poisson", "csm-vsm", "csm-evsm"];
    let seen = |scene| see(scene, None, &street, &names);
    assert_same("stray", &seen(&plain), &seen(&strayed));
    // From above no cascades are compared: the last one of the plain scene is limited to the scene, and so is
    // finer.
    let above = camera([18.0, 22.0, 30.0], [0.0; 3]);
    let seen = |scene| see(scene, None, &above, &["none"]);
    assert_same("stray from above", &seen(&plain), &seen(&strayed));
}

#[test]
#[ignore = "slow: traces and draws large scenes"]
fn ground_of_any_width_changes_nothing_near_the_camera() {
    let boxes = [[0.0, 0.0], [1.5, 3.0]];
    let seen = |half: f32, camera: &Camera, names: &[&str]| {
        see(&ground_and_boxes(half, &boxes, &[]), None, camera, names)
    };
    // One camera looks down, so that all scenes show the same ground, which is wider than their cascades. The
    // other looks to the horizon, just below which only wide scenes have ground.
    let down = camera([0.0, 7.0, 8.0], [0.0; 3]);
    let level = camera([0.0, 1.0, 5.2], [0.0, 1.0, 0.0]);
    let names = ["none", "csm", "csm:filter=1", "csm-evsm"];
    let plain = [seen(200.0, &down, &names), seen(20.0, &level, &["none"])];
    for half in [5e5, 5e4] {
        let what = format!("ground of {half} m");
        assert_same(&what, &plain[0], &seen(half, &down, &names));
        assert_same(&what, &plain[1], &seen(half, &level, &["none"]));
    }
}

/// Renders a city at `origin`.
fn city_at(origin: [f64; 3], resolution: u64, names: &[&str]) -> RenderedView {
    let mut scene = generate(GeneratedKind::City, 1);
    let sun = Sun::from_direction(SUN).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(resolution));
    let file = compared::moved(Bake::with_options(&scene, &options).in_memory().unwrap(), origin);
    for instance in &mut scene.instances {
        (0..3).for_each(|a| instance.world_from_mesh[a][3] += origin[a]);
    }
    let place = |p: [f64; 3]| std::array::from_fn(|a| p[a] + origin[a]);
    let camera = camera(place([-150.0, 38.0, 175.0]), place([-75.0, 4.0, 75.0]));
    see(&scene, Some(&file), &camera, names)
}

#[test]
fn coarse_town_looks_the_same_at_map_coordinates() {
    let at = |origin| city_at(origin, 512, &["none", "voxel"]);
    assert_same("a coarse town", &at([0.0; 3]), &at([10_000_000.0, 0.0, 10_000_000.0]));
}

#[test]
#[ignore = "slow: traces and draws large scenes; both places with ADUMBRA_FULL"]
fn town_looks_the_same_at_map_coordinates() {
    let at = |origin| city_at(origin, 4096, &["none", "voxel", "voxel:filter=5"]);
    let plain = at([0.0; 3]);
    let origins = [[10_000_000.0, 0.0, 10_000_000.0], [500_000.0, 0.0, 5_000_000.0]];
    for origin in origins.into_iter().take(if full() { 2 } else { 1 }) {
        assert_same(&format!("{origin:?}"), &plain, &at(origin));
    }
}

#[test]
fn camera_at_map_coordinates_moves_in_even_steps() {
    let origin = [500_000.0, 0.0, 5_000_000.0];
    let mut scene = ground_and_boxes(20.0, &[[0.0, 0.0]], &[]);
    (0..3).for_each(|a| scene.instances[0].world_from_mesh[a][3] = origin[a]);
    let mut renderer = renderer(&scene);
    let given = Given::new(renderer.gpu(), "lit", [16, 16], &[1.0; 256]).unwrap();
    let mut given = renderer.prepare(Box::new(given)).unwrap();
    let towards_sun = Sun::from_direction(SUN).unwrap().towards();
    let mut depths = Vec::new();
    for step in 0..=1000_u32 {
        // The camera approaches the side of the box by a millimetre per step.
        let away = 5.0 - 0.001 * f64::from(step);
        let eye = [origin[0], 1.0, origin[2] + 1.0 + away];
        let target = [origin[0], 1.0, origin[2]];
        let camera = Camera { width: 16, height: 16, ..camera(eye, target) };
        let shot = Shot { camera, towards_sun, number: 0 };
        renderer.draw(&shot, &mut given, Answer::Visibility).unwrap();
        depths.push(f64::from(renderer.read_surface(&shot).unwrap().view_depth[8 * 16 + 8]));
        assert!((depths[step as usize] - away).abs() < 1e-4, "{step}: {} for {away}", depths[step as usize]);
    }
    let steps: Vec<f64> = depths.windows(2).map(|d| d[0] - d[1]).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    let (least, most) =
        steps.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &s| (least.min(s), most.max(s)));
    assert!(least > 0.0 && most <= 1.5 * mean, "steps of {least} to {most}, {mean} in the mean");
}
