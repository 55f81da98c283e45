//! Days over walls and plains, compared with every ray.

use adumbra_scene::{GeneratedKind, generate};
use adumbra_solar::Day;
use adumbra_testing::{cuboid, scene_of};
use adumbra_truth::trace::TraceOptions;

use super::*;
use crate::points::{Facing, Grid, surface_points};

fn day(text: &str, key_degrees: f64) -> SunDay {
    let day: Day = format!("lat=48.14,lon=11.58,tz=Europe/Berlin,{text}").parse().unwrap();
    SunDay::new(&day.steps().unwrap(), DayOptions { key_degrees }).unwrap()
}

fn at(p_world: [f64; 3], facing: Facing) -> Receiver {
    Receiver { p_world, facing, lift_world: 1e-4 }
}

const UP: Facing = Facing::Front([0.0, 1.0, 0.0]);

/// A long wall from east to west, 1 m thick and 10 m high, on a plain.
fn wall() -> adumbra_scene::Scene {
    scene_of(vec![
        cuboid([-3000.0, -1.0, -3000.0], [3000.0, 0.0, 3000.0]),
        cuboid([-2000.0, 0.0, -0.5], [2000.0, 10.0, 0.5]),
    ])
}

#[test]
fn hours_beside_a_wall_follow_the_sun() {
    let scene = wall();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let day = day("date=2026-03-20,from=0,to=24", 2.0);
    let points = [
        at([0.0, 0.0, 1000.0], UP),
        at([0.0, 0.0, -1.0], UP),
        at([0.0, 5.0, 0.5], Facing::Front([0.0, 0.0, 1.0])),
        at([0.0, 5.0, -0.5], Facing::Front([0.0, 0.0, -1.0])),
        at([0.0, 20.0, 0.0], Facing::Space),
        at([0.0, 20.0, 0.0], Facing::Both([0.0, 0.0, -1.0])),
    ];
    let hours = day.hours(&tracer, &points, Watch::none()).unwrap();
    let minutes: Vec<f64> = (0..points.len()).map(|point| hours.seconds(point) / 60.0).collect();
    let whole = day.sun_seconds() / 60.0;
    // At an equinox the sun's centre is up for 12 hours, and the air adds some minutes.
    assert!((720.0..735.0).contains(&whole), "{whole}");
    // The plain is lit all day, the foot north of the wall only before the sun passes east and after it
    // passes west.
    assert_eq!(minutes[0], whole);
    assert!(minutes[1] < 20.0, "{minutes:?}");
    // The southern face is lit while the sun is in the south, the northern one during the few other minutes.
    assert!(minutes[2] > 700.0 && minutes[2] <= whole, "{minutes:?}");
    assert_eq!(minutes[2] + minutes[3], whole);
    // Above the wall, points are always lit: in space, and on a sheet from one side after the other.
    assert_eq!(minutes[4..], [whole, whole]);
    assert_eq!(hours.steps(5).len(), 1);
}

#[test]
fn night_has_no_hours_and_traces_no_rays() {
    let scene = wall();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let night = day("date=2026-03-20,from=22,to=4", 2.0);
    assert_eq!((night.len(), night.sun_seconds()), (360, 0.0));
    let hours = night.hours(&tracer, &[at([0.0, 0.0, 1000.0], UP)], Watch::none()).unwrap();
    assert_eq!((hours.len(), hours.seconds(0), hours.rays()), (1, 0.0, 0));
}

#[test]
fn hours_across_a_night_have_two_spans() {
    let scene = wall();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let two = day("date=2026-06-20,from=12,to=11", 2.0);
    let hours = two.hours(&tracer, &[at([0.0, 20.0, 0.0], Facing::Space)], Watch::none()).unwrap();
    let [evening, morning] = hours.steps(0) else { panic!("{:?}", hours.steps(0)) };
    assert!(evening[0] == 0 && evening[1] < morning[0] && morning[1] == two.len() as u32);
    assert_eq!(hours.seconds(0), two.sun_seconds());
}

/// Key suns find nearly every minute that all rays find, with a fraction of the rays. With long steps, every
/// sun is a key.
#[test]
fn hours_from_keys_agree_with_every_ray() {
    let scene = generate(GeneratedKind::City, 7);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let ground = Grid::over(&[scene.bounds()], 12.0).unwrap().receivers(&tracer).unwrap().receivers;
    let walls = surface_points(&tracer, 30.0, false).unwrap();
    let points = [ground, walls].concat();
    assert!(points.len() > 500, "{}", points.len());
    let of = |text: &str, degrees: f64| {
        day(&format!("date=2026-09-22,from=8,to=18{text}"), degrees)
            .hours(&tracer, &points, Watch::none())
            .unwrap()
    };
    let (every, keys) = (of("", 0.0), of("", 2.0));
    let wrong = every.difference(&keys).unwrap();
    assert!(wrong < 0.002, "{wrong}");
    assert!(keys.rays() * 5 < every.rays(), "{} of {}", keys.rays(), every.rays());
    // Keys far apart miss more, so the comparison can detect errors.
    assert!(every.difference(&of("", 60.0)).unwrap() > wrong.max(0.005));
    assert_eq!(of(",step=3600", 2.0), of(",step=3600", 0.0));
}

#[test]
fn hours_do_not_depend_on_the_threads() {
    let scene = generate(GeneratedKind::City, 3);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let points = Grid::over(&[scene.bounds()], 4.0).unwrap().receivers(&tracer).unwrap().receivers;
    assert!(points.len() > 2 * BLOCK);
    let day = day("date=2026-09-22,from=8,to=18", 4.0);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| day.hours(&tracer, &points, Watch::none()).unwrap())
    };
    assert_eq!(on(1), on(7));
}

#[test]
fn hours_can_be_cancelled_and_report_progress() {
    let scene = wall();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let day = day("date=2026-03-20,from=8,to=9", 2.0);
    let points = vec![at([0.0, 0.0, 1000.0], UP); BLOCK + 1];
    let stop = std::sync::atomic::AtomicBool::new(true);
    assert!(matches!(day.hours(&tracer, &points, Watch::new(&|_| {}, &stop)), Err(Error::Interrupted)));
    let last = std::sync::Mutex::new(0);
    let go = std::sync::atomic::AtomicBool::new(false);
    let see = |p: Progress| {
        assert_eq!(p.total, 2);
        let mut last = last.lock().unwrap();
        *last = p.done.max(*last);
    };
    day.hours(&tracer, &points, Watch::new(&see, &go)).unwrap();
    assert_eq!(*last.lock().unwrap(), 2);
}

#[test]
fn rejects_days_without_a_span_and_bad_key_angles() {
    let steps: Vec<_> = "lat=0,lon=0,date=2026-03-20,from=8,to=9".parse::<Day>().unwrap().steps().unwrap();
    let of = |steps: &[SunStep], key_degrees| SunDay::new(steps, DayOptions { key_degrees });
    assert!(matches!(of(&steps[..1], 2.0), Err(Error::NoSpan { steps: 1 })));
    assert!(matches!(of(&[steps[1], steps[0]], 2.0), Err(Error::NoSpan { .. })));
    for degrees in [-1.0, 181.0, f64::NAN] {
        assert!(matches!(of(&steps, degrees), Err(Error::Range { .. })));
    }
}

#[test]
fn keys_are_no_farther_apart_than_key_degrees() {
    let day = day("date=2026-06-21,from=7,to=19", 2.0);
    let keys: Vec<usize> = (0..day.len()).filter(|&step| day.is_key[step]).collect();
    assert!((60..130).contains(&keys.len()), "{}", keys.len());
    for pair in keys.windows(2) {
        let cosine = dot(day.towards[pair[0]], day.towards[pair[1]]);
        assert!(cosine.acos().to_degrees() <= 2.0, "{pair:?}");
    }
}
