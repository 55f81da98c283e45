//! Movers: the text that `--move` accepts, the path that leads a ball from sunlight into shadow, and the
//! ball's own shadow along it.

use adumbra::{Filter, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_render::{Answer, Prepared, Renderer, SceneOptions, Shot, TechniqueFiles, build};
use adumbra_scene::{Camera, Projection, Scene};
use adumbra_truth::movers::MoveSpec;
use adumbra_truth::trace::{TraceOptions, Tracer};

use crate::kit;

fn spec(text: &str) -> MoveSpec {
    text.parse().unwrap()
}

#[test]
fn parses_move_options() {
    let moved = spec("sphere:radius=0.5:from=0,1,2:to=-3,4,5:seconds=2");
    assert_eq!(moved.ends_world, Some([[0.0, 1.0, 2.0], [-3.0, 4.0, 5.0]]));
    assert_eq!((moved.radius_world, moved.seconds), (Some(0.5), 2.0));
    assert_eq!(spec("sphere").ends_world, None);
    for wrong in [
        "cube",
        "sphere:radius=-1",
        "sphere:radius=1,x",
        "sphere:radius=1,2",
        "sphere:radius=1:radius=2",
        "sphere:seconds=1e300",
        "sphere:from=0,0,0",
        "sphere:from=0,0:to=1,1,1",
        "sphere:from=0,0,up,0:to=1,1,1",
        "sphere:from=0,0,0,0:to=1,1,1",
        "sphere:x",
    ] {
        assert!(wrong.parse::<MoveSpec>().is_err(), "{wrong}");
    }
}

/// Points on the sunlit side of a ball, with their normals.
fn ball_points(center: [f64; 3], radius: f64, towards_sun: [f64; 3]) -> Vec<([f64; 3], [f64; 3])> {
    let directions = (0..400).map(|i| {
        let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / 400.0;
        let angle = 2.399_963 * f64::from(i);
        let flat = (1.0 - y * y).sqrt();
        [flat * angle.cos(), y, flat * angle.sin()]
    });
    let facing = directions.filter(|n| (0..3).map(|a| n[a] * towards_sun[a]).sum::<f64>() > 0.2);
    facing.map(|n| (std::array::from_fn(|a| center[a] + 1.001 * radius * n[a]), n)).collect()
}

/// Poses the scene and returns the position of the ball's centre at this time.
fn ball_center(scene: &mut Scene, seconds: f64) -> [f64; 3] {
    scene.pose(seconds);
    let ball = scene.movers.instances().last().unwrap();
    scene.instances[ball as usize].to_world([0.0; 3])
}

#[test]
fn ball_rolls_from_sun_to_shade_in_file_and_rays() {
    let mut scene = kit::city();
    let still = scene.clone();
    let tracer = Tracer::build(&still, TraceOptions::default());
    let path = spec("sphere").path(&tracer, kit::sun()).unwrap();
    path.add_to(&mut scene);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(4096));
    let file = Bake::with_options(&still, &options).in_memory().unwrap();
    let sampler = file.sampler(Filter::Box5);
    let end = scene.movers.end_seconds();
    let mut means = Vec::new();
    for i in 0..=8 {
        let center = ball_center(&mut scene, end * f64::from(i) / 8.0);
        let points = ball_points(center, path.radius_world, kit::sun());
        let truth = points.iter().filter(|(p, _)| tracer.sun_visible(*p, kit::sun())).count();
        let found: f64 = points.iter().map(|(p, n)| f64::from(sampler.visibility(*p, Some(*n)))).sum();
        let [truth, found] = [truth as f64, found].map(|v| v / points.len() as f64);
        assert!((truth - found).abs() < 0.1, "{i}: rays {truth}, file {found}");
        means.push(found);
    }
    assert!(means[0] > 0.98 && means[8] < 0.02, "{means:?}");
}

#[test]
fn ball_is_seen_from_its_viewpoint() {
    let still = kit::city();
    let tracer = Tracer::build(&still, TraceOptions::default());
    let path = spec("sphere").path(&tracer, kit::sun()).unwrap();
    let [eye, target] = path.viewpoint(&tracer, kit::sun());
    assert!(eye != target && eye[1] > target[1]);
    for (_, p) in &path.keys {
        let towards = std::array::from_fn(|a| p[a] - eye[a]);
        let hit = tracer.nearest_surface(&adumbra_truth::trace::Ray {
            origin: eye,
            direction: towards,
            t_min: 0.0,
            t_max: 1.0,
        });
        assert!(hit.is_none(), "{p:?} is hidden");
    }
}

const SIZE: [u32; 2] = [320, 180];

/// A pixel's surface point, offset slightly along its normal, and its factor.
struct PixelSample {
    p_world: [f64; 3],
    on_ball: bool,
    factor: f32,
    /// Ray-traced factor, with everything as casters.
    truth: f32,
    /// Whether rays give the same factor at four points slightly around it, so that no shadow edge is near.
    interior: bool,
}

/// Draws a frame and traces rays from those of its pixels that face the sun.
fn frame(
    renderer: &mut Renderer,
    prepared: &mut Prepared,
    shot: &Shot,
    tracer: &Tracer<'_>,
    (center, radius): ([f64; 3], f64),
) -> Vec<PixelSample> {
    renderer.draw(shot, prepared, Answer::Visibility).unwrap();
    let factor = renderer.read_factor(prepared).unwrap();
    let surface = renderer.read_surface(shot).unwrap();
    let view = shot.camera.view();
    let mut seen = Vec::new();
    for (at, (&z, n)) in surface.view_depth.iter().zip(&surface.normal).enumerate() {
        let n = n.map(f64::from);
        let n_dot_l: f64 = (0..3).map(|a| n[a] * shot.towards_sun[a]).sum();
        if !z.is_finite() || n_dot_l < 0.2 {
            continue;
        }
        let (x, y) = (at as u32 % SIZE[0], at as u32 / SIZE[0]);
        let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let along: f64 = (0..3).map(|a| direction[a] * view.forward[a]).sum();
        let p_world: [f64; 3] =
            std::array::from_fn(|a| origin[a] + direction[a] * f64::from(z) / along + 0.01 * n[a]);
        let far: f64 = (0..3).map(|a| (p_world[a] - center[a]).powi(2)).sum::<f64>().sqrt();
        let lit = |dx: f64, dz: f64| {
            let p = [p_world[0] + dx, p_world[1], p_world[2] + dz];
            tracer.sun_visible(p, shot.towards_sun)
        };
        let truth = lit(0.0, 0.0);
        let interior =
            [[0.2, 0.0], [-0.2, 0.0], [0.0, 0.2], [0.0, -0.2]].iter().all(|&[x, z]| lit(x, z) == truth);
        seen.push(PixelSample {
            p_world,
            on_ball: far < 1.05 * radius,
            factor: factor[at],
            truth: f32::from(u8::from(truth)),
            interior,
        });
    }
    seen
}

#[test]
fn ball_on_the_gpu_enters_the_shade_and_casts_a_shadow() {
    let mut scene = kit::city();
    let still = scene.clone();
    let still_tracer = Tracer::build(&still, TraceOptions::default());
    let path = spec("sphere").path(&still_tracer, kit::sun()).unwrap();
    path.add_to(&mut scene);
    let mut moving = scene.clone().take_movers();
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(4096));
    let file = Bake::with_options(&still, &options).in_memory().unwrap();
    let baked = TechniqueFiles::of(&file);
    let mut renderer = Renderer::new(kit::gpu(), &still, SceneOptions::default()).unwrap();
    renderer.set_movers(&moving, SceneOptions::default()).unwrap();
    let [mut voxel, mut both] =
        ["voxel:filter=3", "voxel+csm:filter=3:csm=cascades=2/filter=3"].map(|name| {
            let technique = build(renderer.gpu(), &name.parse().unwrap(), baked).unwrap();
            renderer.prepare(technique).unwrap()
        });
    let [eye, target] = path.viewpoint(&still_tracer, kit::sun());
    let projection = Projection::Perspective { fov_degrees: 45.0 };
    let camera = Camera { eye, target, projection, width: SIZE[0], height: SIZE[1] };
    let shot = Shot { camera, towards_sun: kit::sun(), number: 0 };
    let mut means = Vec::new();
    for i in 0..=2 {
        let seconds = scene.movers.end_seconds() * f64::from(i) / 2.0;
        let center = ball_center(&mut scene, seconds);
        let ball = (center, path.radius_world);
        moving.pose(seconds);
        renderer.move_movers(&moving);
        // The file contains only static casters, not the ball's own shadow.
        let seen = frame(&mut renderer, &mut voxel, &shot, &still_tracer, ball);
        let mean = |value: fn(&PixelSample) -> f32| {
            let on_ball: Vec<f32> = seen.iter().filter(|s| s.on_ball).map(value).collect();
            assert!(on_ball.len() > 50, "{i}: {} pixels of the ball", on_ball.len());
            on_ball.iter().sum::<f32>() / on_ball.len() as f32
        };
        let (found, truth) = (mean(|s| s.factor), mean(|s| s.truth));
        assert!((found - truth).abs() < 0.1, "{i}: {found}, rays {truth}");
        means.push(found);
        // All casters, movers included.
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let wrong = |seen: &[PixelSample]| {
            let interior = seen.iter().filter(|s| s.interior);
            interior.filter(|s| (s.factor - s.truth).abs() > 0.5).count()
        };
        let with = frame(&mut renderer, &mut both, &shot, &tracer, ball);
        let without = frame(&mut renderer, &mut voxel, &shot, &tracer, ball);
        let interior = with.iter().filter(|s| s.interior).count();
        println!("{i}: {} of {interior} wrong, {} without cascades", wrong(&with), wrong(&without));
        assert!(wrong(&with) * 200 < interior, "{i}: {} of {interior} are wrong", wrong(&with));
        if i == 0 {
            assert!(wrong(&without) > wrong(&with) + 20, "the ball casts no shadow to speak of");
            let on_ground = |s: &&PixelSample| !s.on_ball && s.interior && s.truth == 0.0 && s.factor < 0.5;
            let near =
                |s: &&PixelSample| (0..3).map(|a| (s.p_world[a] - center[a]).powi(2)).sum::<f64>() < 9.0;
            assert!(with.iter().filter(on_ground).filter(near).count() > 20);
        }
    }
    assert!(means[0] > 0.95 && means[2] < 0.05 && means.is_sorted_by(|a, b| a >= b), "{means:?}");
}
