//! Ambient occlusion that reuses earlier frames: GPU against CPU for moving cameras, less noise, no ghosting.

use adumbra_render::occlusion::OcclusionPasses;
use adumbra_render::occlusion::twin::Twin;
use adumbra_render::{Answer, Renderer, SceneOptions, Shot, Stage, TechniqueFiles, build};
use adumbra_scene::{Camera, Projection};

use crate::kit;
use crate::kit::ambient::{GBuffer, assert_same, rms, settings, visibility};
use crate::kit::boxes::boxes;

const SIZE: [u32; 2] = [203, 151];
const RADIUS_WORLD: f64 = 8.0;
const ORTHOGRAPHIC: Projection = Projection::Orthographic { height_world: 110.0 };

fn city() -> Renderer {
    Renderer::new(kit::gpu(), &kit::city(), SceneOptions::default()).unwrap()
}

/// Moves a camera along a flight over the city, while it turns.
fn on_demand(camera: Camera, number: u32) -> Camera {
    let t = f64::from(number);
    let moved = |p: [f64; 3], d: [f64; 3]| [0, 1, 2].map(|a| p[a] + t * d[a]);
    Camera {
        eye: moved(camera.eye, [0.8, -0.3, -1.1]),
        target: moved(camera.target, [1.9, 0.1, -0.4]),
        ..camera
    }
}

#[test]
#[ignore = "slow: draws many frames"]
fn gpu_reuse_matches_cpu() {
    let mut renderer = city();
    let texts = [
        "issao:reuse=on",
        "issao:reuse=on:filter=none:frames=3",
        "issao:reuse=on:half=on:filter=square:side=2",
        "issao:reuse=on:normals=depth",
        "issao:reuse=on:half=on:normals=depth:edges=on",
    ];
    for projection in [kit::camera(1, 1).projection, ORTHOGRAPHIC] {
        for [width, height] in [[1, 1], [7, 5], SIZE] {
            let all = texts.map(|text| settings(text, RADIUS_WORLD));
            let mut passes = all.map(|s| OcclusionPasses::new(renderer.gpu(), s));
            let mut twins = all.map(Twin::new);
            for number in 0..5 {
                let camera = on_demand(Camera { projection, ..kit::camera(width, height) }, number);
                let seen = GBuffer::drawn(&mut renderer, camera, number);
                for (i, text) in texts.iter().enumerate() {
                    let found = seen.on_gpu(renderer.gpu(), &mut passes[i]);
                    let expected = visibility(&twins[i].ambient(&seen.surfaces()));
                    let what = format!("{text} at {width} x {height}, frame {number}");
                    assert_same(renderer.gpu(), &found, &expected, &what);
                }
            }
        }
    }
}

/// A camera goes around a block, so that sides come into sight where the front was before.
#[test]
fn gpu_reuse_matches_cpu_where_sides_come_into_view() {
    let scene = boxes(&[([-40.0, -1.0, -40.0], [40.0, 0.0, 40.0]), ([-3.0, 0.0, -3.0], [3.0, 6.0, 3.0])]);
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    let settings = settings("issao:reuse=on:filter=none", 3.0);
    let (mut passes, mut twin) = (OcclusionPasses::new(renderer.gpu(), settings), Twin::new(settings));
    for (number, angle) in [(0, 0.1_f64), (1, 0.1), (2, 0.6), (3, -0.1)] {
        let eye = [16.0 * angle.sin(), 9.0, 16.0 * angle.cos()];
        let camera = Camera { eye, target: [0.0, 2.0, 0.0], ..kit::camera(48, 36) };
        let seen = GBuffer::drawn(&mut renderer, camera, number);
        let found = seen.on_gpu(renderer.gpu(), &mut passes);
        let expected = visibility(&twin.ambient(&seen.surfaces()));
        assert_same(renderer.gpu(), &found, &expected, &format!("frame {number}"));
    }
}

#[test]
fn renderer_keeps_the_history_of_its_frames() {
    let mut renderer = city();
    let none = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut none = renderer.prepare(none).unwrap();
    let settings = settings("issao:reuse=on", RADIUS_WORLD);
    let mut twin = Twin::new(settings);
    let passes = OcclusionPasses::new(renderer.gpu(), settings);
    renderer.set_ambient(Some(passes.into()));
    for number in 0..4 {
        let camera = on_demand(kit::camera(64, 48), number);
        if number == 3 {
            renderer.ambient_mut().unwrap().forget();
            twin.forget();
        }
        let shot = Shot { camera, towards_sun: kit::sun(), number };
        let times = renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
        assert!(times.of(Stage::AmbientHistory) > 0.0);
        let found = renderer.ambient().unwrap().read(renderer.gpu()).unwrap();
        let seen = GBuffer::now(&renderer, &shot);
        let expected = visibility(&twin.ambient(&seen.surfaces()));
        assert_same(renderer.gpu(), &found, &expected, &format!("frame {number}"));
    }
    // Another size restarts the history.
    twin.forget();
    let shot = Shot { camera: kit::camera(48, 40), towards_sun: kit::sun(), number: 4 };
    renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
    let found = renderer.ambient().unwrap().read(renderer.gpu()).unwrap();
    let expected = visibility(&twin.ambient(&GBuffer::now(&renderer, &shot).surfaces()));
    assert_same(renderer.gpu(), &found, &expected, "another size");
}

#[test]
fn reuse_lowers_the_noise() {
    let mut renderer = city();
    for filter in ["none", "bilateral"] {
        let [alone, reusing] =
            ["off", "on"].map(|r| settings(&format!("issao:filter={filter}:reuse={r}"), RADIUS_WORLD));
        let mut twin = Twin::new(reusing);
        // An orthographic camera moves right by one texel per frame, so the picture moves left by one texel.
        let camera = Camera { projection: ORTHOGRAPHIC, ..kit::camera(160, 120) };
        let right = camera.view().right;
        let mut last: Option<[Vec<f32>; 2]> = None;
        let (mut flicker, mut error) = ([0.0; 2], [0.0; 2]);
        for number in 0..10 {
            let by = f64::from(number) * 110.0 / 120.0;
            let moved = |p: [f64; 3]| [0, 1, 2].map(|a| p[a] + by * right[a]);
            let camera = Camera { eye: moved(camera.eye), target: moved(camera.target), ..camera };
            let seen = GBuffer::drawn(&mut renderer, camera, number);
            let now = [seen.on_cpu(&alone), visibility(&twin.ambient(&seen.surfaces()))];
            let last = last.replace(now.clone());
            if let (Some(last), true) = (last, number >= 6) {
                let rows = |v: &[f32], from: usize| -> Vec<f32> {
                    v.chunks(160).flat_map(|row| row[from..from + 159].to_vec()).collect()
                };
                for i in 0..2 {
                    flicker[i] += rms(&rows(&last[i], 1), &rows(&now[i], 0)) / 4.0;
                }
            }
            if number == 9 {
                let smooth = seen.without_noise(&reusing);
                error = [0, 1].map(|i| rms(&now[i], &smooth));
            }
        }
        println!("{filter}: frame to frame {flicker:.4?}, from the mean {error:.4?}, without and with reuse");
        assert!(flicker[1] < 0.5 * flicker[0], "{filter}: {flicker:?}");
        assert!(error[1] < error[0], "{filter}: {error:?}");
    }
}

#[test]
fn reuse_leaves_no_ghost_after_a_disocclusion() {
    let scene = boxes(&[
        ([-200.0, -1.0, -200.0], [200.0, 0.0, 200.0]),
        ([-1.5, 0.0, -1.0], [1.5, 9.0, 1.0]),
        ([-1.5, 5.0, 1.0], [1.5, 5.5, 3.0]),
        ([-9.0, 0.0, -8.0], [9.0, 3.0, -7.0]),
    ]);
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    let camera = |x: f64| Camera {
        eye: [x, 10.0, 16.0],
        target: [0.5 * x, 4.0, 0.0],
        projection: Projection::Perspective { fov_degrees: 50.0 },
        width: SIZE[0],
        height: SIZE[1],
    };
    let [reusing, with_filter] =
        ["none", "bilateral"].map(|f| settings(&format!("issao:reuse=on:filter={f}"), 3.0));
    let [mut twin, mut filtered_twin] = [reusing, with_filter].map(Twin::new);
    for number in 0..8 {
        let seen = GBuffer::drawn(&mut renderer, camera(0.0), number);
        twin.ambient(&seen.surfaces());
        filtered_twin.ambient(&seen.surfaces());
    }
    let before = GBuffer::drawn(&mut renderer, camera(0.0), 7);
    let (old, new) = (camera(0.0).view(), camera(3.0).view());
    let seen = GBuffer::drawn(&mut renderer, camera(3.0), 8);
    let [width, height] = seen.size();
    // Pixels whose point was not visible in the previous frame: each of the four pixels around its position
    // there was covered by something nearer or was outside the picture.
    let is_hidden = |at: usize| {
        let Some(z) = seen.view_depth(at) else { return false };
        let (origin, direction) = new.ray((at % width) as f64 + 0.5, (at / width) as f64 + 0.5);
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
        let t = f64::from(z) / dot(direction, new.forward);
        let p: [f64; 3] = std::array::from_fn(|a| origin[a] + t * direction[a] - old.eye[a]);
        let z = dot(p, old.forward);
        let x = (dot(p, old.right) / (z * old.half[0]) * 0.5 + 0.5) * width as f64 - 0.5;
        let y = (0.5 - dot(p, old.up) / (z * old.half[1]) * 0.5) * height as f64 - 0.5;
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].into_iter().all(|c| {
            let [x, y] = [x.floor() + c[0], y.floor() + c[1]];
            if x < 0.0 || y < 0.0 || x >= width as f64 || y >= height as f64 {
                return true;
            }
            let other = before.view_depth(y as usize * width + x as usize);
            other.is_some_and(|o| f64::from(o) < z - 3.0)
        })
    };
    let hidden: Vec<usize> = (0..width * height).filter(|&at| is_hidden(at)).collect();
    assert!(hidden.len() > 300, "{}", hidden.len());
    let reused = visibility(&twin.ambient(&seen.surfaces()));
    let fresh = visibility(&Twin::new(reusing).ambient(&seen.surfaces()));
    let worst = hidden.iter().map(|&at| (reused[at] - fresh[at]).abs()).fold(0.0, f32::max);
    assert_eq!(worst, 0.0, "of {} disoccluded pixels", hidden.len());
    // Over the whole frame, reuse brings the result nearer to the estimator's mean.
    let [a, b] = [visibility(&filtered_twin.ambient(&seen.surfaces())), seen.on_cpu(&with_filter)];
    let smooth = seen.without_noise(&reusing);
    let (with, without) = (rms(&a, &smooth), rms(&b, &smooth));
    println!("{} disoccluded, whole frame {with:.4} from the mean, {without:.4} without reuse", hidden.len());
    println!("unfiltered {:.4}, {:.4}", rms(&reused, &smooth), rms(&fresh, &smooth));
    assert!(rms(&reused, &smooth) < rms(&fresh, &smooth));
}
