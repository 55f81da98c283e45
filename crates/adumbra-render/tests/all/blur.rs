//! The screen-space blurs: GPU against CPU, and their known defects (halos and gaps), counted on a box in
//! front of distant ground.

use adumbra::Sun;
use adumbra_render::frame::frame;
use adumbra_render::readback::read_floats;
use adumbra_render::screen_blur::twin::{Bleeding, Surfaces, bleeding, blur};
use adumbra_render::screen_blur::{BlurInput, BlurPasses, BlurSettings};
use adumbra_render::{
    Answer, Features, Gpu, GpuOptions, RenderError, Renderer, SceneOptions, Shot, SurfacePoint,
    TechniqueFiles, build,
};
use adumbra_scene::{Camera, Projection, Scene};
use adumbra_testing::{cuboid, scene_of};
use adumbra_truth::trace::{TraceOptions, Tracer};

use crate::kit;

const SIZE: [u32; 2] = [203, 151];

/// A box of 4 × 8 × 4 on a ground of 400 × 400.
fn scene() -> Scene {
    scene_of(vec![
        cuboid([-200.0, -1.0, -200.0], [200.0, 0.0, 200.0]),
        cuboid([-2.0, -0.5, -2.0], [2.0, 8.0, 2.0]),
    ])
}

/// The camera's view, and the ray-traced factor.
struct View {
    renderer: Renderer,
    shot: Shot,
    factor: Vec<f32>,
    depth: Vec<f32>,
    normal: Vec<[f32; 3]>,
    /// Surface number: 1 for the ground, 2 and above for the box's faces, 0 for the sky.
    surface: Vec<u8>,
}

fn view(gpu: Gpu, projection: Projection) -> View {
    let scene = scene();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let mut renderer = Renderer::new(gpu, &scene, SceneOptions::default()).unwrap();
    let none = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
    let mut none = renderer.prepare(none).unwrap();
    let camera = Camera {
        eye: [3.0, 13.0, 12.0],
        target: [-4.0, 3.0, -1.0],
        projection,
        width: SIZE[0],
        height: SIZE[1],
    };
    let towards_sun = Sun::from_direction([0.6, 0.4, 0.3]).unwrap().towards();
    let shot = Shot { camera, towards_sun, number: 0 };
    renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
    let seen = renderer.read_surface(&shot).unwrap();
    let axes = camera.view();
    let mut factor = Vec::new();
    let mut surface = Vec::new();
    for (at, (&z, n)) in seen.view_depth.iter().zip(&seen.normal).enumerate() {
        if !z.is_finite() {
            factor.push(1.0);
            surface.push(0);
            continue;
        }
        let (x, y) = (at as u32 % SIZE[0], at as u32 / SIZE[0]);
        let (origin, direction) = axes.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let along: f64 = (0..3).map(|a| direction[a] * axes.forward[a]).sum();
        let n = n.map(f64::from);
        let p: [f64; 3] =
            std::array::from_fn(|a| origin[a] + direction[a] * f64::from(z) / along + 1e-3 * n[a]);
        let faces_sun = (0..3).map(|a| n[a] * shot.towards_sun[a]).sum::<f64>() > 0.0;
        factor.push(f32::from(u8::from(faces_sun && tracer.sun_visible(p, shot.towards_sun))));
        let axis = (0..3).find(|&a| n[a].abs() > 0.9).unwrap() as u8;
        surface.push(if p[1] < 0.01 { 1 } else { 2 + axis });
    }
    let depth = read_floats(renderer.gpu(), &renderer.targets().unwrap().depth.texture, 0, 0).unwrap();
    View { renderer, shot, factor, depth, normal: seen.normal, surface }
}

const PERSPECTIVE: Projection = Projection::Perspective { fov_degrees: 50.0 };
const ORTHOGRAPHIC: Projection = Projection::Orthographic { height_world: 14.0 };

fn settings(text: &str) -> BlurSettings {
    BlurSettings::of(&text.parse().unwrap()).unwrap()
}

impl View {
    fn on_cpu(&self, settings: &BlurSettings) -> Vec<f32> {
        let frame = frame(&self.shot.camera, &self.renderer.bounds(), self.shot.towards_sun, 0);
        blur(settings, &self.factor, &Surfaces { frame, depth: &self.depth, normal: &self.normal })
    }

    fn on_gpu(&self, settings: BlurSettings) -> (Vec<f32>, BlurPasses) {
        let gpu = self.renderer.gpu();
        let texture = |usage| {
            let usage = usage | wgpu::TextureUsages::TEXTURE_BINDING;
            gpu.texture("test", SIZE, wgpu::TextureFormat::R32Float, usage)
        };
        let factor = texture(wgpu::TextureUsages::COPY_DST);
        let bytes: Vec<u8> = self.factor.iter().flat_map(|f| f.to_le_bytes()).collect();
        let rows =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIZE[0]), rows_per_image: None };
        gpu.queue.write_texture(factor.as_image_copy(), &bytes, rows, factor.size());
        let filtered = texture(wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_SRC);
        let targets = self.renderer.targets().unwrap();
        let frame = frame(&self.shot.camera, &self.renderer.bounds(), self.shot.towards_sun, 0);
        let mut passes = BlurPasses::new(gpu, settings);
        let mut encoder = gpu.encoder("test");
        let input = BlurInput {
            size: SIZE,
            frame: &gpu.uniform("frame", &frame.bytes()),
            depth: &targets.depth.view,
            normal: &targets.normal.view,
            factor: &factor.create_view(&Default::default()),
            filtered: &filtered.create_view(&Default::default()),
        };
        passes.encode(gpu, &mut encoder, &input);
        gpu.finish(encoder.finish()).unwrap();
        (read_floats(gpu, &filtered, 0, 0).unwrap(), passes)
    }

    /// Counts the pixels that a blur changed by more than 0.02 although no pixel of the other value is within
    /// its reach on the same surface: lit ones (halo) and shadowed ones (gap). Also returns the largest such
    /// change.
    fn bleeding(&self, blurred: &[f32], reach: i32) -> Bleeding {
        let mut found = Bleeding::default();
        let [width, height] = SIZE.map(|s| s as i32);
        for (at, (&before, &after)) in self.factor.iter().zip(blurred).enumerate() {
            let (x, y) = (at as i32 % width, at as i32 / width);
            let around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| [x + dx, y + dy]));
            let own_border = around
                .filter(|&[x, y]| (0..width).contains(&x) && (0..height).contains(&y))
                .map(|[x, y]| (y * width + x) as usize)
                .any(|other| self.surface[other] == self.surface[at] && self.factor[other] != before);
            if self.surface[at] == 0 || own_border {
                continue;
            }
            let change = (before - after).abs();
            found.largest = found.largest.max(change);
            if change > 0.02 {
                *(if before == 1.0 { &mut found.halo } else { &mut found.gap }) += 1;
            }
        }
        found
    }
}

/// Together, these use every pass.
const ALL: [&str; 13] = [
    "blur:samples=8",
    "blur:samples=64:sigma=9",
    "blur:weights=shader",
    "blur:passes=1:samples=10",
    "blur:passes=1:samples=10:weights=shader",
    "blur:pairs=on",
    "blur:samples=10:pairs=on",
    "blur:half=on",
    "blur:half=on:pairs=on:samples=32",
    "blur-dilate:radius=3",
    "blur-bilateral",
    "blur-bilateral:passes=1:samples=10",
    "blur-bilateral:half=on",
];

#[test]
fn gpu_blur_matches_cpu() {
    for projection in [PERSPECTIVE, ORTHOGRAPHIC] {
        let view = view(kit::gpu(), projection);
        for text in ALL {
            let settings = settings(text);
            let expected = view.on_cpu(&settings);
            let (found, _) = view.on_gpu(settings);
            let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 1e-3, "{text}: {worst}");
            let changed = found.iter().zip(&view.factor).filter(|(a, b)| (*a - *b).abs() > 0.05).count();
            assert!(changed > 200, "{text}: {changed} pixels are softer");
        }
    }
}

#[test]
fn plain_blur_bleeds_over_silhouettes_and_bilateral_does_not() {
    let view = view(kit::gpu(), PERSPECTIVE);
    let bleeding = |text: &str| {
        let settings = settings(text);
        let (blurred, _) = view.on_gpu(settings);
        let reach = settings.samples / 2 + 3;
        let found = view.bleeding(&blurred, reach as i32);
        // The measure that uses only depth and normals gives about the same counts.
        let frame = frame(&view.shot.camera, &view.renderer.bounds(), view.shot.towards_sun, 0);
        let surfaces = Surfaces { frame, depth: &view.depth, normal: &view.normal };
        let judged = bleeding(&view.factor, &blurred, &surfaces, reach);
        assert!(judged.halo.abs_diff(found.halo) * 20 <= found.halo + 20, "{text}: {judged:?} {found:?}");
        assert!(judged.gap.abs_diff(found.gap) * 20 <= found.gap + 40, "{text}: {judged:?} {found:?}");
        println!("{text}: {found:?}");
        found
    };
    let plain = bleeding("blur:samples=16");
    assert!(plain.halo > 200 && plain.gap > 50 && plain.largest > 0.3, "{plain:?}");
    // More samples give more halo.
    let wide = bleeding("blur:samples=32");
    assert!(wide.halo > plain.halo, "{wide:?} {plain:?}");
    // Dilation with any radius leaves some gap and enlarges the halo.
    for radius in 1..=3 {
        let dilated = bleeding(&format!("blur-dilate:samples=16:radius={radius}"));
        assert!(
            dilated.gap > 0 && dilated.gap < plain.gap && dilated.halo > plain.halo,
            "{radius} {dilated:?}"
        );
    }
    for text in ["blur-bilateral:samples=16", "blur-bilateral:samples=16:passes=1", "blur-bilateral:half=on"]
    {
        let within = bleeding(text);
        assert!(within.halo == 0 && within.gap == 0 && within.largest < 0.01, "{text} {within:?}");
    }
}

#[test]
fn blur_without_float_filtering_disables_pairs() {
    let options = GpuOptions { without: Features::FLOAT32_FILTERABLE, ..GpuOptions::default() };
    let view = view(Gpu::request(&options).unwrap(), PERSPECTIVE);
    let asked = settings("blur:pairs=on");
    let (found, passes) = view.on_gpu(asked);
    assert!(asked.pairs && !passes.settings().pairs);
    let expected = view.on_cpu(&asked);
    assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-3));
}

#[test]
fn blur_keeps_cascade_numbers_and_rejects_points() {
    let mut renderer = Renderer::new(kit::gpu(), &scene(), SceneOptions::default()).unwrap();
    let shot = Shot { camera: kit::camera(SIZE[0], SIZE[1]), towards_sun: kit::sun(), number: 0 };
    let [mut plain, mut blurred, mut none] =
        ["csm:size=256:far=300", "blur:base=csm/size=256/far=300", "none"].map(|name| {
            let technique = build(renderer.gpu(), &name.parse().unwrap(), TechniqueFiles::default()).unwrap();
            renderer.prepare(technique).unwrap()
        });
    let [expected, found] = [&mut plain, &mut blurred].map(|technique| {
        renderer.draw(&shot, technique, Answer::Cascade).unwrap();
        renderer.read_factor(technique).unwrap()
    });
    assert!(expected == found);
    assert!(expected.iter().any(|&n| n >= 1.0) && expected.iter().all(|n| n.fract() == 0.0));
    let refused = renderer.draw(&shot, &mut none, Answer::Cascade).unwrap_err();
    assert!(matches!(refused, RenderError::Technique { .. }), "{refused}");
    let point = SurfacePoint { p_world: shot.camera.target, normal: [0.0, 1.0, 0.0] };
    let refused = renderer.answer(&shot, &mut blurred, &[point]).unwrap_err();
    assert!(matches!(refused, RenderError::Technique { .. }), "{refused}");
}

#[test]
fn blur_wraps_another_technique() {
    let gpu = kit::gpu();
    let make = |text: &str| build(&gpu, &text.parse()?, TechniqueFiles::default());
    let blur = make("blur:samples=8:base=none").unwrap();
    assert!(blur.has_screen_passes());
    assert_eq!(blur.name(), "blur:samples=8:base=none");
    assert!(make("blur:base=blur").is_err() && make("blur:base=nonsense").is_err());
    let mut renderer = Renderer::new(gpu, &scene(), SceneOptions::default()).unwrap();
    let mut prepared = renderer.prepare(blur).unwrap();
    let camera = kit::camera(SIZE[0], SIZE[1]);
    let shot = Shot { camera, towards_sun: kit::sun(), number: 0 };
    renderer.draw(&shot, &mut prepared, Answer::Visibility).unwrap();
    assert!(renderer.read_factor(&prepared).unwrap().iter().any(|&f| f > 0.99));
    assert!(prepared.technique().bytes() >= u64::from(SIZE[0] * SIZE[1] * 4));
}
