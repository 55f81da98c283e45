//! Tests of worked splits, of spheres that hold their slices, and of texels that do not move.

use adumbra::{Bounds, LightExtent, Sun};
use adumbra_scene::{Camera, Projection};

use super::*;

const SCENE: Bounds = Bounds { min: [-300.0, -5.0, -250.0], max: [280.0, 60.0, 330.0] };

fn extent(azimuth: f64, elevation: f64) -> LightExtent {
    let mut extent = LightExtent::empty(&Sun::from_angles(azimuth, elevation).unwrap());
    extent.add_box(&SCENE);
    extent
}

fn camera(eye: [f64; 3], turn: f64, projection: Projection) -> View {
    let target = [eye[0] + libm::cos(turn), eye[1] - 0.2, eye[2] + libm::sin(turn)];
    Camera { eye, target, projection, width: 1280, height: 720 }.view()
}

const PERSPECTIVE: Projection = Projection::Perspective { fov_degrees: 50.0 };

#[test]
fn splits_have_worked_values() {
    let near =
        |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    assert!(near(&split_depths(Split::Uniform, 4, [0.0, 100.0]), &[25.0, 50.0, 75.0, 100.0]));
    assert!(near(&split_depths(Split::Logarithmic, 3, [1.0, 1000.0]), &[10.0, 100.0, 1000.0]));
    // A start of 0 is replaced by a thousandth of the far depth, 0.1, so slices end at 0.1 · 10^(3i/3).
    assert!(near(&split_depths(Split::Logarithmic, 3, [0.0, 100.0]), &[1.0, 10.0, 100.0]));
    let practical = Split::Practical { lambda: 0.5 };
    assert!(near(&split_depths(practical, 3, [1.0, 1000.0]), &[172.0, 383.5, 1000.0]));
    for (lambda, other) in [(0.0, Split::Uniform), (1.0, Split::Logarithmic)] {
        let practical = split_depths(Split::Practical { lambda }, 8, [2.0, 700.0]);
        assert!(near(&practical, &split_depths(other, 8, [2.0, 700.0])));
    }
}

#[test]
fn slices_lie_inside_their_sphere_and_touch_it() {
    for projection in [PERSPECTIVE, Projection::Orthographic { height_world: 40.0 }] {
        for slice in [[0.0, 10.0], [8.0, 40.0], [90.0, 95.0]] {
            let view = camera([3.0, 4.0, 5.0], 0.7, projection);
            let (centre, radius) = slice_sphere(&view, slice);
            let mut farthest = 0.0_f64;
            for p in corners(&view, slice) {
                let d: f64 = (0..3).map(|a| (p[a] - centre[a]).powi(2)).sum::<f64>().sqrt();
                farthest = farthest.max(d);
            }
            assert!((farthest - radius).abs() < 1e-9 * radius, "{slice:?} {farthest} {radius}");
        }
    }
}

/// The eight corners of a slice.
fn corners(view: &View, slice: [f64; 2]) -> Vec<[f64; 3]> {
    let mut corners = Vec::new();
    for depth in slice {
        for (x, y) in [(0.0, 0.0), (1280.0, 0.0), (0.0, 720.0), (1280.0, 720.0)] {
            let (origin, direction) = view.ray(x, y);
            let along: f64 = (0..3).map(|a| direction[a] * view.forward[a]).sum();
            corners.push(std::array::from_fn(|a| origin[a] + depth / along * direction[a]));
        }
    }
    corners
}

#[test]
fn layers_hold_every_scene_point_of_their_slice_with_the_margin() {
    let (size, margin) = (512, 4.0);
    for (azimuth, elevation) in [(0.0, 90.0), (200.0, 5.0), (310.0, 40.0)] {
        let extent = extent(azimuth, elevation);
        let scene = scene_layer(&extent, depth_range(&extent, None), [0.0; 3], size, margin);
        for projection in [PERSPECTIVE, Projection::Orthographic { height_world: 90.0 }] {
            let view = camera([12.0, 30.0, -40.0], 2.1, projection);
            let reach = reach(&view, &SCENE, None);
            let layers = cascade_layers(&view, &scene, &CascadeSettings::default(), reach, margin, true);
            let (mut begin, mut tested) = (0.0, 0);
            for layer in &layers {
                for step in 0..4000_u32 {
                    let part = |n: u32| f64::from(step.wrapping_mul(n) >> 8 & 0xffff) / 65536.0;
                    let (origin, direction) =
                        view.ray(part(2_654_435_761) * 1280.0, part(2_246_822_519) * 720.0);
                    let depth = begin + part(3_266_489_917) * (layer.end[0] - begin);
                    let along: f64 = (0..3).map(|a| direction[a] * view.forward[a]).sum();
                    let p: [f64; 3] = std::array::from_fn(|a| origin[a] + depth / along * direction[a]);
                    if (0..3).any(|a| p[a] < SCENE.min[a] || p[a] > SCENE.max[a]) {
                        continue;
                    }
                    let [x, y, z] = layer.project(p);
                    let inside = margin..=f64::from(size) - margin;
                    assert!(inside.contains(&x) && inside.contains(&y), "{x} {y}");
                    assert!((0.0..=1.0).contains(&z));
                    tested += 1;
                }
                begin = layer.end[1];
            }
            assert!(tested > 1000, "{tested}");
        }
    }
}

#[test]
fn texels_stay_fixed_while_the_camera_moves_and_turns() {
    let extent = extent(310.0, 40.0);
    let settings = CascadeSettings { cascades: 3, ..Default::default() };
    let scene = scene_layer(&extent, depth_range(&extent, None), [0.0; 3], 1024, 4.0);
    let fit = |view: &View| cascade_layers(view, &scene, &settings, [0.0, 400.0], 4.0, true);
    let first = fit(&camera([0.0, 10.0, 0.0], 0.0, PERSPECTIVE));
    let mut moved = 0;
    for step in 1..200 {
        let s = f64::from(step);
        let eye = [0.37 * s, 10.0 + libm::sin(s), -0.123_456_7 * s];
        let layers = fit(&camera(eye, 0.01 * s, PERSPECTIVE));
        for (layer, before) in layers.iter().zip(&first) {
            assert_eq!(layer.texel_world, before.texel_world);
            moved += u32::from(layer.corner != before.corner);
            // A fixed world point keeps its position in its texel, also in the 32-bit floats that shaders
            // use.
            let p = [17.25, 1.5, -31.0];
            let phase = |l: &LayerFit, anchor: [f64; 3]| {
                let rows = l.layer(anchor);
                let relative: [f32; 3] = std::array::from_fn(|a| (p[a] - anchor[a]) as f32);
                [rows.u_from_relative, rows.v_from_relative].map(|r| {
                    let along = r[0] * relative[0] + r[1] * relative[1] + r[2] * relative[2] + r[3];
                    f64::from(along) * f64::from(l.size)
                })
            };
            let (now, then) = (phase(layer, eye), phase(before, [0.0; 3]));
            for a in 0..2 {
                let apart = now[a] - then[a] + (layer.corner[a] - before.corner[a]) as f64;
                assert!(apart.abs() < 2e-3, "{apart}");
            }
        }
    }
    assert!(moved > 100);
}

#[test]
fn scene_layer_holds_the_scene_tightly() {
    for (azimuth, elevation) in [(0.0, 90.0), (200.0, 5.0), (310.0, 40.0)] {
        let extent = extent(azimuth, elevation);
        let layer = scene_layer(&extent, depth_range(&extent, None), [5.0, -3.0, 0.7], 2048, 3.0);
        let longest = extent.longest_side() / layer.texel_world;
        assert!(longest <= 2048.0 - 6.0 && longest > 2040.0, "{longest}");
        for corner in 0..8_usize {
            let pick = |a: usize| if corner >> a & 1 == 0 { SCENE.min[a] } else { SCENE.max[a] };
            let [x, y, z] = layer.project([pick(0), pick(1), pick(2)]);
            assert!((3.0..=2045.0).contains(&x) && (3.0..=2045.0).contains(&y) && z > 0.0 && z < 1.0);
        }
    }
}

#[test]
fn reach_rounds_the_visible_depth_up_to_a_power_of_two() {
    // From the middle of the scene, the box's far corners are about 400 away.
    let inside = camera([0.0, 10.0, 0.0], 1.0, PERSPECTIVE);
    assert_eq!(reach(&inside, &SCENE, None), [0.0, 512.0]);
    let far = Camera {
        eye: [0.0, 10.0, 3000.0],
        target: [0.0; 3],
        projection: PERSPECTIVE,
        width: 1280,
        height: 720,
    };
    let [near, end] = reach(&far.view(), &SCENE, None);
    assert_eq!(end, 4096.0);
    assert!((1850.0..2670.0).contains(&near), "{near}");
    assert_eq!(reach(&far.view(), &SCENE, Some(70.0)), [0.0, 70.0]);
    let up = Camera { target: [0.0, 20.0, 3001.0], ..far };
    assert!(reach(&up.view(), &SCENE, None)[1] > 0.0, "what sees nothing still has a reach");
}

#[test]
fn geometry_outside_the_view_changes_no_cascade() {
    let strayed = Bounds { max: [1e6, 60.0, 1e6], ..SCENE };
    let fit = |bounds: &Bounds| {
        let mut extent = LightExtent::empty(&Sun::from_angles(310.0, 40.0).unwrap());
        extent.add_box(bounds);
        let scene = scene_layer(&extent, depth_range(&extent, None), [0.0; 3], 2048, 4.0);
        // Looks towards the corner that both boxes share.
        let view = camera([-200.0, 8.0, -150.0], 3.9, PERSPECTIVE);
        cascade_layers(&view, &scene, &CascadeSettings::default(), reach(&view, bounds, None), 4.0, true)
    };
    let (alone, with) = (fit(&SCENE), fit(&strayed));
    for (a, b) in alone.iter().zip(&with) {
        assert_eq!((a.end, a.texel_world, a.corner), (b.end, b.texel_world, b.corner));
        assert!(b.depth_world[1] - b.depth_world[0] < 700.0, "{:?}", b.depth_world);
    }
}

#[test]
fn depth_range_grows_in_steps_to_include_movers() {
    let still = extent(310.0, 40.0);
    let alone = depth_range(&still, None);
    assert_eq!(depth_range(&still, Some(&still)), alone);
    let mut all = still;
    all.min[2] -= 1.0;
    let grown = depth_range(&still, Some(&all));
    assert!(grown[0] < all.min[2] && grown[1] == alone[1]);
    all.min[2] -= 1.0;
    assert_eq!(depth_range(&still, Some(&all)), grown);
}

#[test]
fn layers_do_not_depend_on_the_scene_s_position() {
    let sun = Sun::from_angles(310.0, 40.0).unwrap();
    let first = [3.5, 0.25, -7.0];
    let fit = |place: [f64; 3]| {
        let at = |p: [f64; 3]| std::array::from_fn(|a| p[a] + place[a]);
        let bounds = Bounds { min: at(SCENE.min), max: at(SCENE.max) };
        let mut extent = LightExtent::empty(&sun);
        extent.add_box(&bounds);
        let scene = scene_layer(&extent, depth_range(&extent, None), at(first), 2048, 4.0);
        let (eye, target) = (at([-50.0, 8.0, -60.0]), at([0.0, 5.0, 1.0]));
        let view = Camera { eye, target, projection: PERSPECTIVE, width: 1280, height: 720 }.view();
        let reach = reach(&view, &bounds, None);
        let layers = cascade_layers(&view, &scene, &CascadeSettings::default(), reach, 4.0, true);
        layers
            .into_iter()
            .map(|layer| (layer.project(at([1.0, 2.0, 3.0])), layer.texel_world))
            .collect::<Vec<_>>()
    };
    let at_zero = fit([0.0; 3]);
    for place in [[500_000.0, 0.0, 5_000_000.0], [1e7, 0.0, 1e7]] {
        for (a, b) in at_zero.iter().zip(&fit(place)) {
            assert!((a.1 - b.1).abs() < 1e-9 * a.1, "{a:?} {b:?}");
            assert!((0..3).all(|k| (a.0[k] - b.0[k]).abs() < 1e-4), "{a:?} {b:?}");
        }
    }
}
