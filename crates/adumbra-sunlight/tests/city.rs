//! Hours from key suns compared with every ray, at 20,000 points of a real scene, and the time for a million
//! points.

use std::time::Instant;

use adumbra_scene::{LoadOptions, Scene, load};
use adumbra_solar::Day;
use adumbra_sunlight::{DayOptions, Grid, Hours, Receiver, SunDay, Watch, surface_points};
use adumbra_testing::{full, scene_file, shared};
use adumbra_truth::trace::{TraceOptions, Tracer};

fn city() -> Option<Scene> {
    let path = scene_file(&shared("scenes")?, "kaykit_city_21");
    Some(load(&path, &LoadOptions::default()).expect("the scene"))
}

/// The edge of a square such that `points` squares cover an area.
fn spacing(area: f64, points: f64) -> f64 {
    (area / points).sqrt()
}

fn ground(scene: &Scene, tracer: &Tracer<'_>, points: f64) -> Vec<Receiver> {
    let bounds = scene.bounds();
    let side = |a: usize| bounds.max[a] - bounds.min[a];
    let grid = Grid::over(&[bounds], spacing(side(0) * side(2), points)).expect("a grid");
    grid.receivers(tracer).expect("ground").receivers
}

fn day(date: &str, key_degrees: f64) -> SunDay {
    let day: Day =
        format!("lat=48.14,lon=11.58,tz=Europe/Berlin,date={date},from=8,to=18").parse().expect("a day");
    SunDay::new(&day.steps().expect("steps"), DayOptions { key_degrees }).expect("suns")
}

fn timed(day: &SunDay, tracer: &Tracer<'_>, points: &[Receiver]) -> (Hours, f64) {
    let start = Instant::now();
    let hours = day.hours(tracer, points, Watch::none()).expect("hours");
    (hours, start.elapsed().as_secs_f64())
}

#[test]
#[ignore = "slow: traces every minute of a day from 20,000 points; three days and key distances with ADUMBRA_FULL"]
fn key_suns_differ_from_every_ray_in_less_than_a_thousandth() {
    let Some(scene) = city() else { return };
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let ground = ground(&scene, &tracer, 10_000.0);
    let areas = surface_points(&tracer, 1.0, false).expect("points").len() as f64;
    let walls = surface_points(&tracer, spacing(areas, 10_000.0), false).expect("points");
    let points = [ground, walls].concat();
    assert!(points.len() > 18_000, "{}", points.len());
    let chosen = DayOptions::default().key_degrees;
    let (dates, distances): (&[_], &[_]) = if full() {
        (&["2026-03-20", "2026-06-21", "2026-12-21"], &[1.0, 2.0, 4.0])
    } else {
        (&["2026-03-20"], &[chosen])
    };
    for &date in dates {
        let (every, whole_seconds) = timed(&day(date, 0.0), &tracer, &points);
        for &degrees in distances {
            let (keys, seconds) = timed(&day(date, degrees), &tracer, &points);
            let wrong = every.difference(&keys).expect("the same points");
            let rays = keys.rays() as f64 / points.len() as f64;
            println!(
                "{date}, keys {degrees}° apart: {:.4} % of minutes differ, {rays:.1} rays a point for {:.1}, {seconds:.2} s for {whole_seconds:.2}",
                100.0 * wrong,
                every.rays() as f64 / points.len() as f64
            );
            if degrees == chosen {
                assert!(wrong < 0.001, "{date}: {wrong}");
            }
        }
    }
}

#[test]
#[ignore = "slow: traces ten hours from a million points"]
fn hours_of_a_million_points_are_timed() {
    let Some(scene) = city() else { return };
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let points = ground(&scene, &tracer, 1e6);
    for date in ["2026-03-20", "2026-06-21"] {
        let (hours, seconds) = timed(&day(date, DayOptions::default().key_degrees), &tracer, &points);
        let lit: f64 = (0..hours.len()).map(|point| hours.seconds(point)).sum();
        println!(
            "{date}: {} points, {} rays in {seconds:.1} s, {:.2} h in the mean",
            points.len(),
            hours.rays(),
            lit / 3600.0 / points.len() as f64
        );
        assert!(lit > 0.0);
    }
}
