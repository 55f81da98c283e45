//! Ambient occlusion on drawn frames: GPU against CPU, planes, corners, and scenes in other units.

use adumbra_render::frame::frame;
use adumbra_render::occlusion::twin::{Surfaces, ambient};
use adumbra_render::occlusion::{Estimator, OcclusionPasses, OcclusionSettings};
use adumbra_render::readback::read_floats;
use adumbra_render::{Answer, Renderer, SceneOptions, Shot, TechniqueFiles, build};
use adumbra_scene::{Camera, Projection, Scene};

use crate::kit;
use crate::kit::ambient::{VARIANTS, assert_same};
use crate::kit::boxes::boxes;

/// Further settings of `issao` that are compared on drawn frames.
const PRESETS: [&str; 2] =
    ["issao:preset=fig4:reading=2:levels=off", "issao:preset=fig5:relation=free:before=surface"];

/// A renderer and the shot that it drew last.
struct View {
    renderer: Renderer,
    shot: Shot,
}

impl View {
    fn new(scene: &Scene, camera: Camera) -> Self {
        let mut renderer = Renderer::new(kit::gpu(), scene, SceneOptions::default()).unwrap();
        let shot = Shot { camera, towards_sun: kit::sun(), number: 0 };
        let none = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
        let mut none = renderer.prepare(none).unwrap();
        renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
        Self { renderer, shot }
    }

    /// Computes the ambient visibility of each pixel.
    fn occlude(&self, text: &str, radius_world: f64) -> Vec<f32> {
        let mut passes = OcclusionPasses::new(self.renderer.gpu(), settings(text, radius_world));
        self.renderer.occlude(&self.shot, &mut passes).unwrap();
        passes.read(self.renderer.gpu()).unwrap()
    }

    /// World position of each pixel's surface; `None` for the sky.
    fn points(&self) -> Vec<Option<[f64; 3]>> {
        let axes = self.shot.camera.view();
        let width = self.shot.camera.width;
        let depths = self.renderer.read_surface(&self.shot).unwrap().view_depth;
        (0..)
            .zip(depths)
            .map(|(at, z)| {
                let (x, y) = (f64::from(at % width) + 0.5, f64::from(at / width) + 0.5);
                let (origin, direction) = axes.ray(x, y);
                let along: f64 = (0..3).map(|a| direction[a] * axes.forward[a]).sum();
                z.is_finite()
                    .then(|| std::array::from_fn(|a| origin[a] + direction[a] * f64::from(z) / along))
            })
            .collect()
    }
}

fn settings(text: &str, radius_world: f64) -> OcclusionSettings {
    OcclusionSettings::from_spec(&text.parse().unwrap(), radius_world).unwrap()
}

fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0, 0), |(s, n), v| (s + f64::from(v), n + 1));
    (sum / f64::from(count.max(1))) as f32
}

#[test]
fn gpu_occlusion_matches_cpu() {
    let perspective = kit::camera(203, 151);
    let orthographic = Camera { projection: Projection::Orthographic { height_world: 120.0 }, ..perspective };
    for camera in [perspective, orthographic] {
        let view = View::new(&kit::city(), camera);
        let View { renderer, shot } = &view;
        let depth = read_floats(renderer.gpu(), &renderer.targets().unwrap().depth.texture, 0, 0).unwrap();
        let normal = renderer.read_surface(shot).unwrap().normal;
        let frame = frame(&shot.camera, &renderer.bounds(), shot.towards_sun, 0);
        let each = Estimator::ALL.iter().flat_map(|e| [e.to_string(), format!("{e}:filter=none")]);
        let variants = VARIANTS.iter().chain(&PRESETS).map(|v| format!("{v}:filter=none"));
        for text in each.chain(variants) {
            let found = view.occlude(&text, 8.0);
            let surfaces = Surfaces { frame, depth: &depth, normal: &normal };
            let expected = ambient(&settings(&text, 8.0), &surfaces);
            let expected: Vec<f32> = expected.iter().map(|ambient| ambient[0]).collect();
            assert_same(renderer.gpu(), &found, &expected, text.as_ref());
            let mean = mean(found.iter().copied());
            assert!(mean < 0.995 && mean > 0.3, "{text}: {mean}");
        }
    }
}

/// Rotates a vector such that no axis stays an axis, because 16-bit normals are exact only along the axes.
fn tilted([x, y, z]: [f64; 3]) -> [f64; 3] {
    let turn = |[a, b]: [f64; 2], angle: f64| {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        [cos * a - sin * b, sin * a + cos * b]
    };
    let [x, y] = turn([x, y], 0.57);
    let [y, z] = turn([y, z], 0.31);
    [x, y, z]
}

fn tilted_scene(mut scene: Scene) -> Scene {
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(tilted);
    for instance in &mut scene.instances {
        instance.world_from_mesh =
            std::array::from_fn(|row| [columns[0][row], columns[1][row], columns[2][row], 0.0]);
    }
    scene
}

#[test]
fn plane_is_unoccluded() {
    let ground = tilted_scene(boxes(&[([-500.0, -1.0, -500.0], [500.0, 0.0, 500.0])]));
    for degrees in [90.0_f64, 45.0, 15.0, 5.0] {
        for (projection, distance) in [
            (Projection::Perspective { fov_degrees: 45.0 }, 10.0),
            (Projection::Orthographic { height_world: 8.0 }, 100.0),
        ] {
            let angle = degrees.to_radians();
            let eye = tilted([0.0, distance * libm::sin(angle), distance * libm::cos(angle)]);
            let view =
                View::new(&ground, Camera { eye, target: [0.0; 3], projection, width: 129, height: 97 });
            let points = view.points();
            for (estimator, filter, radius_world) in Estimator::ALL
                .into_iter()
                .flat_map(|e| ["none", "bilateral"].map(|f| (e, f)))
                .flat_map(|(e, f)| [0.5, 2.0].map(|r| (e, f, r)))
            {
                let found = view.occlude(&format!("{estimator}:filter={filter}"), radius_world);
                let on_ground = || points.iter().zip(&found).filter(|(p, _)| p.is_some()).map(|(_, v)| *v);
                let (mean, least) = (mean(on_ground()), on_ground().fold(1.0, f32::min));
                let what = format!("{estimator} {filter} {degrees}° {projection:?} {radius_world}");
                println!("{what}: {mean} {least}");
                assert!(on_ground().count() > 1000 && mean > 0.99 && least > 0.9, "{what}: {mean} {least}");
            }
        }
    }
}

/// Ground y = 0 and a wall x = 0, framed for a radius of 2.
fn corner() -> View {
    let scene =
        boxes(&[([-60.0, -1.0, -60.0], [60.0, 0.0, 60.0]), ([-61.0, -1.0, -60.0], [0.0, 60.0, 60.0])]);
    let projection = Projection::Perspective { fov_degrees: 50.0 };
    let camera =
        Camera { eye: [12.0, 9.0, 4.0], target: [1.5, 0.5, 0.0], projection, width: 203, height: 151 };
    View::new(&scene, camera)
}

#[test]
fn inside_corner_is_darker_than_a_plane() {
    let view = corner();
    let points = view.points();
    for estimator in Estimator::ALL {
        let found = view.occlude(estimator.name(), 2.0);
        // Rings by distance from the corner, in radii. Visibility is nearly 1/2 in the corner and 1 from one
        // radius on.
        let at = |from: f64, to: f64| {
            let of = |p: &[f64; 3]| (from..to).contains(&(p[0].max(p[1]) / 2.0));
            mean(points.iter().zip(&found).filter(|(p, _)| p.as_ref().is_some_and(of)).map(|(_, v)| *v))
        };
        let rings = [at(0.0, 0.15), at(0.15, 0.4), at(0.4, 0.8), at(1.3, 2.0)];
        println!("{estimator}: {rings:?}");
        assert!(
            rings[0] < rings[2] && rings[1] < rings[3] && rings[2] < rings[3] + 0.01,
            "{estimator}: {rings:?}"
        );
        assert!(rings[0] < rings[3] - 0.15, "{estimator}: {rings:?}");
    }
}

#[test]
fn gtao_with_many_taps_matches_the_integral_in_a_corner() {
    let view = corner();
    let text = "gtao:samples=64:falloff=0.99:power=1:distribution=1:cap=1000:filter=none";
    let found = view.occlude(text, 2.0);
    // Cosine-weighted directions fill the unit disc uniformly. A wall at distance u R occludes its segment x
    // < -u.
    let open = |u: f64| 1.0 - (libm::acos(u) - u * (1.0 - u * u).sqrt()) / std::f64::consts::PI;
    let near = view.points().into_iter().zip(&found).filter_map(|(p, v)| {
        let u = p.map(|p| p[0].max(p[1]).max(0.0) / 2.0)?;
        (u < 1.0).then(|| v - open(u) as f32)
    });
    let (bias, error) = (mean(near.clone()), mean(near.clone().map(f32::abs)));
    println!("{bias} {error}");
    assert!(near.count() > 3000 && bias.abs() < 0.005 && error < 0.02, "{bias} {error}");
}

/// Returns the scene scaled to other units.
fn scaled(scene: &Scene, by: f32) -> Scene {
    let mut scene = scene.clone();
    scene.meshes.iter_mut().flat_map(|m| &mut m.positions).flatten().for_each(|c| *c *= by);
    scene.instances.iter_mut().flat_map(|i| &mut i.world_from_mesh).for_each(|row| row[3] *= f64::from(by));
    scene
}

#[test]
fn occlusion_does_not_depend_on_the_scene_s_unit() {
    let camera = kit::camera(203, 151);
    let [eye, target] = [camera.eye, camera.target].map(|p| p.map(|c| 1000.0 * c));
    let metres = View::new(&kit::city(), camera);
    let millimetres = View::new(&scaled(&kit::city(), 1000.0), Camera { eye, target, ..camera });
    for estimator in Estimator::ALL {
        let text = format!("{estimator}:filter=none");
        let (a, b) = (metres.occlude(&text, 7.3), millimetres.occlude(&text, 7300.0));
        let differences = || a.iter().zip(&b).map(|(a, b)| (a - b).abs());
        // 1000 is not a power of two, so depths differ in their last bits, and a tap on the edge between two
        // texels may take the other one.
        let moved = differences().filter(|d| *d > 1e-3).count();
        println!(
            "{estimator}: {} and {moved} texels",
            differences().filter(|d| *d <= 1e-3).fold(0.0, f32::max)
        );
        assert!(moved <= a.len() / 10_000, "{estimator}: {moved}");
    }
}
