//! Shadow maps over several frames: cached layers, shadows of movers, and cascades without shimmer.

use adumbra_render::readback::read_floats;
use adumbra_render::{Answer, Prepared, Renderer, SceneOptions, Shot, SurfacePoint, TechniqueFiles, build};
use adumbra_scene::{Camera, Scene};

use crate::kit;
use crate::kit::boxes::boxes;

fn prepare(renderer: &Renderer, name: &str) -> Prepared {
    let technique = build(renderer.gpu(), &name.parse().unwrap(), TechniqueFiles::default()).unwrap();
    renderer.prepare(technique).unwrap()
}

/// A raised box in front of the camera, moved `along` metres to the side.
fn mover(along: f64) -> Scene {
    let mut scene = boxes(&[([-104.0, 14.0, 110.0], [-96.0, 18.0, 118.0])]);
    scene.instances[0].world_from_mesh[0][3] = along;
    scene
}

fn depth_of(renderer: &Renderer, technique: &Prepared) -> Vec<f32> {
    let map = technique.technique().map().unwrap();
    let layers = 0..map.settings().layers();
    layers.flat_map(|l| read_floats(renderer.gpu(), map.depth_texture(), 0, l).unwrap()).collect()
}

#[test]
fn cached_layers_match_redrawn_ones() {
    let mut renderer = Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap();
    renderer.set_movers(&mover(0.0), SceneOptions::default()).unwrap();
    let mut redrawn = prepare(&renderer, "csm:size=256");
    let mut cached = prepare(&renderer, "csm:size=256:static=cached");
    assert!(cached.technique().bytes() >= redrawn.technique().bytes() + 4 * 256 * 256 * 4);
    let mut last = Vec::new();
    for step in 0..6 {
        renderer.move_movers(&mover(3.0 * f64::from(step)));
        let mut camera = kit::camera(64, 36);
        if step >= 3 {
            // Far enough to move the first layers.
            camera.eye[0] += 11.0;
            camera.target[0] += 11.0;
        }
        let shot = Shot { camera, towards_sun: kit::sun(), number: step };
        let mut depths = [&mut redrawn, &mut cached].map(|technique| {
            renderer.draw(&shot, technique, Answer::Visibility).unwrap();
            depth_of(&renderer, technique)
        });
        let apart = depths[0].iter().zip(&depths[1]).filter(|(a, b)| (*a - *b).abs() > 1e-5).count();
        // Cached layers were drawn relative to another eye, so a triangle's edge may round to the other side
        // of a texel's centre.
        assert!(apart * 5000 < depths[0].len(), "frame {step}: {apart} texels differ");
        let moved = depths[0].iter().zip(&last).filter(|(a, b)| a != b).count();
        assert!(step == 0 || moved > 20, "frame {step}: the mover casts nothing");
        last = std::mem::take(&mut depths[0]);
    }
}

#[test]
fn cached_layers_show_movers_and_keep_no_trace_of_them() {
    let mut renderer = Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap();
    let shot = Shot { camera: kit::camera(160, 90), towards_sun: kit::sun(), number: 0 };
    let mut cached = prepare(&renderer, "csm:size=512:static=cached");
    renderer.draw(&shot, &mut cached, Answer::Visibility).unwrap();
    let without = depth_of(&renderer, &cached);
    renderer.set_movers(&mover(0.0), SceneOptions::default()).unwrap();
    renderer.draw(&shot, &mut cached, Answer::Visibility).unwrap();
    let with = depth_of(&renderer, &cached);
    assert!(with.iter().zip(&without).all(|(a, b)| a <= b));
    assert!(with.iter().zip(&without).filter(|(a, b)| a < b).count() > 100);
    renderer.move_movers(&mover(1000.0));
    renderer.draw(&shot, &mut cached, Answer::Visibility).unwrap();
    assert!(depth_of(&renderer, &cached) == without);
}

/// Looks up fixed points while the camera walks and turns. Limits the share of points at shadow edges whose
/// factor changes from frame to frame.
#[test]
#[ignore = "slow: draws many frames"]
fn cascades_do_not_shimmer() {
    let scene = kit::city();
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    let first = kit::camera(160, 90);
    let mut csm = prepare(&renderer, "csm:size=1024");
    let shot = |step: u32| {
        let s = 0.05 * f64::from(step);
        let eye = [first.eye[0] + s, first.eye[1] + 0.3 * s, first.eye[2] - 0.7 * s];
        let target = [first.target[0] - 0.5 * s, first.target[1], first.target[2] + 0.4 * s];
        Shot { camera: Camera { eye, target, ..first }, towards_sun: kit::sun(), number: step }
    };
    renderer.draw(&shot(0), &mut csm, Answer::Visibility).unwrap();
    let surface = renderer.read_surface(&shot(0)).unwrap();
    let view = first.view();
    let mut points = Vec::new();
    for (at, (&depth, normal)) in surface.view_depth.iter().zip(&surface.normal).enumerate() {
        if depth.is_finite() {
            let (origin, direction) = view.ray((at % 160) as f64 + 0.5, (at / 160) as f64 + 0.5);
            let along: f64 = (0..3).map(|a| direction[a] * view.forward[a]).sum();
            let t = f64::from(depth) / along;
            let p_world = std::array::from_fn(|a| origin[a] + t * direction[a]);
            points.push(SurfacePoint { p_world, normal: normal.map(f64::from) });
        }
    }
    let (mut before, mut edges, mut changed, mut moved) = (Vec::new(), 0, 0, 0);
    let mut places = Vec::new();
    for step in 0..40 {
        let now = renderer.answer(&shot(step), &mut csm, &points).unwrap();
        let layers = csm.technique().map().unwrap().params().layers.0;
        let place = layers[0].u_from_relative;
        moved += usize::from(step > 0 && places != place.to_vec());
        places = place.to_vec();
        for (a, b) in now.iter().zip(&before) {
            let (a, b): (f32, f32) = (*a, *b);
            if a.min(b) < 0.95 && a.max(b) > 0.05 {
                edges += 1;
                changed += usize::from((a - b).abs() > 0.05);
            }
        }
        before = now;
    }
    println!("shimmer: {changed} of {edges} edge points per frame change by more than 0.05");
    assert!(edges > 20_000 && moved > 20, "{edges} {moved}");
    assert!(changed * 100 < edges, "{changed} of {edges}");
}

/// Returns the least and greatest value. All must be finite.
fn range(values: &[f32]) -> [f32; 2] {
    assert!(values.iter().all(|v| v.is_finite()));
    values.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &v| [low.min(v), high.max(v)])
}

#[test]
fn draws_a_scene_of_movers_only() {
    let nothing = Scene { instances: Vec::new(), ..mover(0.0) };
    // A plate over a floor, both of them movers.
    let plate = boxes(&[([-6.0, 0.0, -6.0], [6.0, 0.5, 6.0]), ([-2.0, 3.0, -2.0], [2.0, 3.5, 2.0])]);
    let mut renderer = Renderer::new(kit::gpu(), &nothing, SceneOptions::default()).unwrap();
    let camera = Camera { eye: [-9.0, 8.0, 11.0], target: [0.0, 1.0, 0.0], ..kit::camera(96, 54) };
    let shot = Shot { camera, towards_sun: kit::sun(), number: 0 };
    for name in ["pcf:size=512", "csm:size=512", "csm-vsm:size=512", "csm:size=512:static=cached"] {
        let mut technique = prepare(&renderer, name);
        for movers in [None, Some(&plate)] {
            if let Some(movers) = movers {
                renderer.set_movers(movers, SceneOptions::default()).unwrap();
            }
            renderer.draw(&shot, &mut technique, Answer::Visibility).unwrap();
            let map = technique.technique().map().unwrap().params();
            let layers = &map.layers.0[..map.layer_count as usize];
            assert!(!layers.is_empty());
            for layer in layers {
                let rows = [layer.u_from_relative, layer.v_from_relative, layer.depth_from_relative];
                let scales =
                    [layer.texel_world, layer.depth_world, layer.end_view_depth, layer.blend_view_depth];
                assert!(
                    rows.as_flattened().iter().chain(&scales).all(|c| c.is_finite()),
                    "{name}: {layer:?}"
                );
            }
        }
        let factors = renderer.read_factor(&technique).unwrap();
        let [low, high] = range(&factors);
        assert!(low < 1e-4 && (high - 1.0).abs() < 1e-4, "{name}: {low} {high}");
        // A point of the floor in the plate's shadow, and one outside it.
        let [x, z] = [0, 2].map(|a| -2.5 * kit::sun()[a] / kit::sun()[1]);
        let at = |x, z| SurfacePoint { p_world: [x, 0.5, z], normal: [0.0, 1.0, 0.0] };
        let answers = renderer.answer(&shot, &mut technique, &[at(x, z), at(-5.0, 4.0)]).unwrap();
        assert!(answers[0] < 0.1 && answers[1] > 0.9, "{name}: {answers:?}");
    }
}

#[test]
fn points_outside_every_layer_are_lit() {
    let still = boxes(&[([-6.0, 0.0, -6.0], [6.0, 0.5, 6.0]), ([-2.0, 3.0, -2.0], [2.0, 3.5, 2.0])]);
    let mut renderer = Renderer::new(kit::gpu(), &still, SceneOptions::default()).unwrap();
    let beside = boxes(&[([30.0, 0.0, -3.0], [36.0, 4.0, 3.0]), ([-40.0, 0.0, -3.0], [-34.0, 4.0, 3.0])]);
    renderer.set_movers(&beside, SceneOptions::default()).unwrap();
    let camera = Camera { eye: [10.0, 40.0, 60.0], target: [0.0, 0.0, 0.0], ..kit::camera(96, 54) };
    let shot = Shot { camera, towards_sun: kit::sun(), number: 0 };
    let tops = [33.0, -37.0].map(|x| SurfacePoint { p_world: [x, 4.0, 0.0], normal: [0.0, 1.0, 0.0] });
    for name in
        ["sm", "pcf", "pcf:filter=2", "pcf:filter=poisson", "pcss", "vsm", "evsm", "msm", "csm", "csm-evsm"]
    {
        let mut technique = prepare(&renderer, &format!("{name}:size=512"));
        let answers = renderer.answer(&shot, &mut technique, &tops).unwrap();
        assert!(answers.iter().all(|&lit| lit > 0.99), "{name}: {answers:?}");
    }
}

#[test]
fn set_movers_accepts_more_movers_than_before() {
    let mut renderer = Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap();
    let shot = Shot { camera: kit::camera(64, 36), towards_sun: kit::sun(), number: 0 };
    let mut cached = prepare(&renderer, "csm:size=256:static=cached");
    let mut redrawn = prepare(&renderer, "csm:size=256");
    for count in [1, 40] {
        let mut movers = mover(0.0);
        let first = movers.instances[0].clone();
        movers.instances = vec![first; count];
        for (instance, along) in movers.instances.iter_mut().zip(0..) {
            instance.world_from_mesh[0][3] = 2.0 * f64::from(along);
        }
        renderer.set_movers(&movers, SceneOptions::default()).unwrap();
        let [a, b] = [&mut cached, &mut redrawn].map(|technique| {
            renderer.draw(&shot, technique, Answer::Visibility).unwrap();
            depth_of(&renderer, technique)
        });
        assert!(a == b, "{count} movers");
    }
}

#[test]
fn cached_layers_are_not_reused_for_another_scene() {
    let shot = Shot { camera: kit::camera(64, 36), towards_sun: kit::sun(), number: 0 };
    let first =
        boxes(&[([-160.0, 0.0, 0.0], [0.0, 1.0, 180.0]), ([-104.0, 14.0, 110.0], [-96.0, 18.0, 118.0])]);
    // The same bounding box, with the small box elsewhere.
    let second =
        boxes(&[([-160.0, 0.0, 0.0], [0.0, 1.0, 180.0]), ([-94.0, 14.0, 100.0], [-86.0, 18.0, 108.0])]);
    let gpu = kit::gpu();
    let share = || adumbra_render::Gpu::sharing(&gpu.device, &gpu.queue);
    let [mut a, mut b] =
        [&first, &second].map(|scene| Renderer::new(share(), scene, SceneOptions::default()).unwrap());
    let mut cached = prepare(&a, "pcf:size=256:static=cached");
    let mut redrawn = prepare(&b, "pcf:size=256");
    a.draw(&shot, &mut cached, Answer::Visibility).unwrap();
    b.draw(&shot, &mut cached, Answer::Visibility).unwrap();
    b.draw(&shot, &mut redrawn, Answer::Visibility).unwrap();
    assert!(depth_of(&b, &cached) == depth_of(&b, &redrawn));
}
