//! Days over walls and plains, compared with rays at each second.

use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_solar::{Day, position};
use adumbra_testing::{cuboid, scene_of};
use adumbra_truth::trace::TraceOptions;

use super::*;
use crate::points::{Grid, surface_points};

fn day(text: &str) -> Day {
    format!("lat=48.14,lon=11.58,tz=Europe/Berlin,{text}").parse().unwrap()
}

fn suns(text: &str) -> Suns {
    Suns::new(&day(text).arcs().unwrap())
}

fn at(p_world: [f64; 3], facing: Facing) -> Receiver {
    Receiver { p_world, facing, lift_world: 1e-4 }
}

const UP: Facing = Facing::Front([0.0, 1.0, 0.0]);

/// A long wall from east to west, 1 m thick and 10 m high, on a plain.
fn wall() -> Scene {
    scene_of(vec![
        cuboid([-3000.0, -1.0, -3000.0], [3000.0, 0.0, 3000.0]),
        cuboid([-2000.0, 0.0, -0.5], [2000.0, 10.0, 0.5]),
    ])
}

#[test]
fn hours_beside_a_wall_follow_the_sun() {
    let scene = wall();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let suns = suns("date=2026-03-20,from=0,to=24");
    let points = [
        at([0.0, 0.0, 1000.0], UP),
        at([0.0, 0.0, -1.0], UP),
        at([0.0, 5.0, 0.5], Facing::Front([0.0, 0.0, 1.0])),
        at([0.0, 5.0, -0.5], Facing::Front([0.0, 0.0, -1.0])),
        at([0.0, 20.0, 0.0], Facing::Space),
        at([0.0, 20.0, 0.0], Facing::Both([0.0, 0.0, -1.0])),
    ];
    let hours = suns.hours(&tracer, &points, Watch::none()).unwrap();
    let seconds: Vec<f64> = (0..points.len()).map(|point| hours.seconds(point)).collect();
    let whole = suns.seconds();
    // At an equinox the sun's centre is up for 12 hours, and the air adds some minutes.
    assert!((720.0..735.0).contains(&(whole / 60.0)), "{whole}");
    // The plain is lit all day, the foot north of the wall only before the sun passes east and after it
    // passes west.
    assert_eq!(seconds[0], whole);
    assert!(seconds[1] < 1200.0, "{seconds:?}");
    // The southern face is lit while the sun is in the south, the northern one during the few other minutes.
    assert!(seconds[2] > 42_000.0 && seconds[2] <= whole, "{seconds:?}");
    assert!((seconds[2] + seconds[3] - whole).abs() < 1e-3, "{seconds:?}");
    // Above the wall, points are always lit: in space, and on a sheet from one side after the other.
    assert_eq!(seconds[4..], [whole, whole]);
    assert_eq!(hours.spans(5).len(), 1);
}

#[test]
fn night_has_no_hours() {
    let scene = wall();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let night = suns("date=2026-03-20,from=22,to=4");
    assert_eq!(night.seconds(), 0.0);
    let hours = night.hours(&tracer, &[at([0.0, 0.0, 1000.0], UP)], Watch::none()).unwrap();
    assert_eq!((hours.len(), hours.seconds(0)), (1, 0.0));
}

#[test]
fn hours_across_a_night_have_two_spans() {
    let scene = wall();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let two = suns("date=2026-06-20,from=12,to=11");
    let hours = two.hours(&tracer, &[at([0.0, 20.0, 0.0], Facing::Space)], Watch::none()).unwrap();
    let [evening, morning] = hours.spans(0) else { panic!("{:?}", hours.spans(0)) };
    let [from, to] = day("date=2026-06-20,from=12,to=11").ends().unwrap().map(|time| time as f64);
    assert!(evening[0] == from && evening[1] < morning[0] && morning[1] == to);
    assert!((hours.seconds(0) - two.seconds()).abs() < 1e-6);
}

/// At 40 points on the ground and on walls of a town, each second from 8 to 18 h is as a ray says, except
/// where a span ends within that second.
#[test]
fn hours_agree_with_rays_at_each_second() {
    let scene = generate(GeneratedKind::City, 7);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let ground = Grid::over(&[scene.bounds()], 40.0).unwrap().receivers(&tracer).unwrap().receivers;
    let walls = surface_points(&tracer, 70.0, false).unwrap();
    let points: Vec<Receiver> =
        ground.into_iter().step_by(5).take(20).chain(walls.into_iter().take(20)).collect();
    assert_eq!(points.len(), 40);
    let day = day("date=2026-09-22,from=8,to=18");
    let hours = Suns::new(&day.arcs().unwrap()).hours(&tracer, &points, Watch::none()).unwrap();
    let [from, to] = day.ends().unwrap();
    let mut events = 0;
    for second in (from..=to).step_by(7) {
        let second = second as f64;
        let towards = position(&day.location, second, day.atmosphere.as_ref()).unwrap().towards();
        for (number, point) in points.iter().enumerate() {
            let spans = hours.spans(number);
            if spans.iter().flatten().any(|end| (end - second).abs() < 0.1) {
                continue;
            }
            let lit = match point.facing {
                Facing::Both(normal) => {
                    let side = if dot(normal, towards) > 0.0 { 1.0 } else { -1.0 };
                    tracer.sun_visible(point.origin(side), towards)
                }
                _ => point.faces(towards) && tracer.sun_visible(point.origin(1.0), towards),
            };
            let expected = spans.iter().any(|span| span[0] <= second && second <= span[1]);
            assert_eq!(lit, expected, "{point:?} at {second} in {spans:?}");
        }
    }
    for number in 0..points.len() {
        events += hours.spans(number).len();
    }
    assert!(events > points.len() / 2, "{events} spans");
}

#[test]
fn hours_do_not_depend_on_the_threads() {
    let scene = generate(GeneratedKind::City, 3);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let points = Grid::over(&[scene.bounds()], 4.0).unwrap().receivers(&tracer).unwrap().receivers;
    assert!(points.len() > 2 * BLOCK);
    let suns = suns("date=2026-09-22,from=8,to=10");
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| suns.hours(&tracer, &points, Watch::none()).unwrap())
    };
    assert_eq!(on(1), on(7));
}

#[test]
fn hours_can_be_cancelled_and_report_progress() {
    let scene = wall();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let suns = suns("date=2026-03-20,from=8,to=9");
    let points = vec![at([0.0, 0.0, 1000.0], UP); BLOCK + 1];
    let stop = std::sync::atomic::AtomicBool::new(true);
    assert!(matches!(suns.hours(&tracer, &points, Watch::new(&|_| {}, &stop)), Err(Error::Interrupted)));
    let last = std::sync::Mutex::new(0);
    let go = std::sync::atomic::AtomicBool::new(false);
    let see = |p: Progress| {
        assert_eq!(p.total, 2);
        let mut last = last.lock().unwrap();
        *last = p.done.max(*last);
    };
    suns.hours(&tracer, &points, Watch::new(&see, &go)).unwrap();
    assert_eq!(*last.lock().unwrap(), 2);
}
