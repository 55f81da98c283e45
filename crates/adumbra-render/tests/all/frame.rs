//! The G-buffer against rays, and the composite against the CPU renderer.

use adumbra::Sun;
use adumbra_render::{Answer, Renderer, SceneOptions, Shot, TechniqueFiles, build};
use adumbra_scene::{Camera, Projection};
use adumbra_truth::picture;
use adumbra_truth::picture::Shadows;
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};

use crate::kit;

const SIZE: [u32; 2] = [160, 90];

fn cameras() -> [Camera; 2] {
    let perspective = kit::camera(SIZE[0], SIZE[1]);
    [perspective, Camera { projection: Projection::Orthographic { height_world: 120.0 }, ..perspective }]
}

#[test]
fn gbuffer_matches_rays() {
    let scene = kit::city();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    let none = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut none = renderer.prepare(none).unwrap();
    for camera in cameras() {
        let shot = Shot { camera, towards_sun: kit::sun(), number: 0 };
        renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
        let surface = renderer.read_surface(&shot).unwrap();
        let view = camera.view();
        // GPUs move corners to the nearest 256th of a pixel, which changes the depth of slanted surfaces.
        let moved = if renderer.gpu().is_software() { 0.0 } else { 1.0 / 128.0 };
        let (mut hits, mut far_off, mut turned) = (0, 0, 0);
        for (at, (&depth, normal)) in surface.view_depth.iter().zip(&surface.normal).enumerate() {
            let (x, y) = (at as u32 % SIZE[0], at as u32 / SIZE[0]);
            let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let ray = Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY };
            let Some(hit) = tracer.nearest_surface(&ray) else {
                far_off += usize::from(depth.is_finite());
                continue;
            };
            hits += 1;
            let p: [f64; 3] = std::array::from_fn(|a| origin[a] + hit.t * direction[a]);
            let expected = view.depth(p);
            let beside = |dx: f64, dy: f64| {
                let (origin, direction) = view.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy);
                let hit = tracer.nearest_surface(&Ray { origin, direction, ..ray });
                hit.map_or(expected, |hit| {
                    view.depth(std::array::from_fn(|a| origin[a] + hit.t * direction[a]))
                })
            };
            let around = [beside(-moved, 0.0), beside(moved, 0.0), beside(0.0, -moved), beside(0.0, moved)];
            let slack = around.iter().map(|z| (z - expected).abs()).fold(1e-3 * expected, f64::max);
            if (f64::from(depth) - expected).abs() > slack {
                far_off += 1;
                continue;
            }
            let sign =
                if (0..3).map(|a| hit.normal[a] * direction[a]).sum::<f64>() > 0.0 { -1.0 } else { 1.0 };
            let cosine: f64 = (0..3).map(|a| sign * hit.normal[a] * f64::from(normal[a])).sum();
            turned += usize::from(cosine < 0.999);
        }
        assert!(hits > 5000, "{hits}");
        // Rasterisation and rays differ if a silhouette passes through a pixel's centre.
        assert!(far_off * 500 < hits, "{far_off} of {hits} are elsewhere");
        assert!(turned * 500 < hits, "{turned} of {hits} are turned elsewhere");
    }
}

#[test]
fn composite_matches_the_cpu_renderer() {
    let scene = kit::city();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let mut renderer = Renderer::new(kit::gpu(), &scene, SceneOptions::default()).unwrap();
    let none = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut none = renderer.prepare(none).unwrap();
    let camera = cameras()[0];
    let towards_sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap().towards();
    let shot = Shot { camera, towards_sun, number: 0 };
    renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
    let gpu = renderer.read_picture().unwrap();
    let cpu = picture::draw(&scene, &tracer, &camera, towards_sun, &Shadows::File(&kit::AllLit), 1);
    let differing = gpu
        .as_chunks::<4>()
        .0
        .iter()
        .zip(cpu.rgb.as_chunks::<3>().0)
        .filter(|(g, c)| (0..3).any(|a| g[a].abs_diff(c[a]) > 3))
        .count();
    assert!(differing * 200 < cpu.rgb.len() / 3, "{differing} pixels differ");
}
