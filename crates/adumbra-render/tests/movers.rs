//! Movers: what `--move` takes, the path that leads a ball from the sun into the shade, and the ball's shade on the way.

mod kit;

use std::sync::atomic::AtomicBool;

use adumbra::bake::{Options, Size, bake};
use adumbra::format::ShadowFile;
use adumbra::light::Sun;
use adumbra::query::Query;
use adumbra::scene::Scene;
use adumbra::trace::{TraceOptions, Tracer};
use adumbra_render::movers::MoveSpec;

fn spec(text: &str) -> MoveSpec {
    text.parse().unwrap()
}

#[test]
fn moves_are_read() {
    let moved = spec("sphere:radius=0.5:from=0,1,2:to=-3,4,5:seconds=2");
    assert_eq!(moved.ends_world, Some([[0.0, 1.0, 2.0], [-3.0, 4.0, 5.0]]));
    assert_eq!((moved.radius_world, moved.seconds), (Some(0.5), 2.0));
    assert_eq!(spec("sphere").ends_world, None);
    for wrong in ["cube", "sphere:radius=-1", "sphere:from=0,0,0", "sphere:from=0,0:to=1,1,1", "sphere:x"] {
        assert!(wrong.parse::<MoveSpec>().is_err(), "{wrong}");
    }
}

/// Points on the upper half of the sun's side of a ball, with their normals.
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

/// Where the ball's centre is at a time, by the scene that holds it.
fn ball_center(scene: &mut Scene, seconds: f64) -> [f64; 3] {
    scene.pose(seconds);
    let ball = scene.movers.instances().last().unwrap();
    scene.instances[ball as usize].to_world([0.0; 3])
}

#[test]
fn ball_goes_from_the_sun_into_the_shade_and_the_file_says_so() {
    let mut scene = kit::city();
    let still = scene.clone();
    let tracer = Tracer::build(&still, TraceOptions::default());
    let path = spec("sphere").path(&tracer, kit::sun()).unwrap();
    path.add_to(&mut scene);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = Options::new(sun, Size::Resolution(4096));
    let baked = bake(&still, &options, &|_| {}, &AtomicBool::new(false)).unwrap();
    let file = ShadowFile { grid: baked.grid, settings: baked.settings, dag: baked.dag };
    let query = Query::new(&file.grid, &file.dag, file.settings.bias, 5).unwrap();
    let end = scene.movers.end_seconds();
    let mut means = Vec::new();
    for i in 0..=8 {
        let center = ball_center(&mut scene, end * f64::from(i) / 8.0);
        let points = ball_points(center, path.radius_world, kit::sun());
        let truth = points.iter().filter(|(p, _)| tracer.sun_visible(*p, kit::sun())).count();
        let found: f64 = points.iter().map(|(p, n)| f64::from(query.visibility(*p, Some(*n)))).sum();
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
        let hit = tracer.nearest_surface(&adumbra::trace::Ray {
            origin: eye,
            direction: towards,
            t_min: 0.0,
            t_max: 1.0,
        });
        assert!(hit.is_none(), "{p:?} is hidden");
    }
}
