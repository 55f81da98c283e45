//! Hours at points of a real scene: compared with rays at each second, and timed.

use std::time::Instant;

use adumbra_scene::{LoadOptions, Scene, load};
use adumbra_solar::{Day, position};
use adumbra_sunlight::points::Facing;
use adumbra_sunlight::{Grid, Hours, Receiver, Suns, Watch, surface_points};
use adumbra_testing::{full, scene_file, shared};
use adumbra_truth::trace::{TraceOptions, Tracer};
use rayon::prelude::*;

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

fn walls(tracer: &Tracer<'_>, points: f64) -> Vec<Receiver> {
    let areas = surface_points(tracer, 1.0, false).expect("points").len() as f64;
    surface_points(tracer, spacing(areas, points), false).expect("points")
}

fn day(date: &str) -> Day {
    format!("lat=48.14,lon=11.58,tz=Europe/Berlin,date={date},from=8,to=18").parse().expect("a day")
}

fn timed(day: &Day, tracer: &Tracer<'_>, points: &[Receiver]) -> (Hours, f64) {
    let start = Instant::now();
    let suns = Suns::new(&day.arcs().expect("arcs"));
    let hours = suns.hours(tracer, points, Watch::none()).expect("hours");
    (hours, start.elapsed().as_secs_f64())
}

/// Whether a ray from a point to the sun meets nothing.
fn is_lit(tracer: &Tracer<'_>, point: &Receiver, towards: [f64; 3]) -> bool {
    let cosine = point.normal().map(|normal| (0..3).map(|a| normal[a] * towards[a]).sum::<f64>());
    let side = match (point.facing, cosine) {
        (Facing::Front(_), Some(cosine)) if cosine <= 0.0 => return false,
        (Facing::Both(_), Some(cosine)) if cosine <= 0.0 => -1.0,
        _ => 1.0,
    };
    let lift = side * point.lift_world;
    let normal = point.normal().unwrap_or_default();
    tracer.sun_visible(std::array::from_fn(|a| point.p_world[a] + lift * normal[a]), towards)
}

#[test]
#[ignore = "slow: a ray for each second of a day from 200 points; from 2,000 on two days with ADUMBRA_FULL"]
fn hours_equal_rays_at_each_second() {
    let Some(scene) = city() else { return };
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let (dates, count): (&[_], f64) =
        if full() { (&["2026-03-20", "2026-12-21"], 1000.0) } else { (&["2026-03-20"], 100.0) };
    let points = [ground(&scene, &tracer, count), walls(&tracer, count)].concat();
    for &date in dates {
        let day = day(date);
        let (hours, seconds) = timed(&day, &tracer, &points);
        let [from, to] = day.ends().expect("ends");
        let suns: Vec<(f64, [f64; 3])> = (from..to)
            .map(|second| {
                let second = second as f64;
                (second, position(&day.location, second, day.atmosphere.as_ref()).expect("a sun").towards())
            })
            .collect();
        // Of each point, the seconds for which the two differ, and the largest distance of one of these
        // from an end of a span.
        let compared: Vec<(u64, f64)> = points
            .par_iter()
            .enumerate()
            .map(|(number, point)| {
                let spans = hours.spans(number);
                let differing = suns.iter().filter(|(second, towards)| {
                    let expected = spans.iter().any(|span| span[0] <= *second && *second < span[1]);
                    *second > 0.0 && (towards[1] > 0.0 && is_lit(&tracer, point, *towards)) != expected
                });
                differing.fold((0, 0.0_f64), |(count, farthest), (second, _)| {
                    let near = spans.iter().flatten().map(|end| (end - second).abs());
                    (count + 1, farthest.max(near.fold(f64::INFINITY, f64::min)))
                })
            })
            .collect();
        let differing: u64 = compared.iter().map(|(count, _)| count).sum();
        let farthest = compared.iter().map(|(_, farthest)| *farthest).fold(0.0, f64::max);
        let spans: usize = (0..points.len()).map(|point| hours.spans(point).len()).sum();
        println!(
            "{date}: {} points, {spans} spans in {seconds:.3} s; {differing} of {} seconds differ from rays, the farthest by {farthest:.3} s",
            points.len(),
            points.len() * suns.len()
        );
        assert!(farthest < 0.1, "{farthest}");
    }
}

#[test]
#[ignore = "slow: ten hours at a million points"]
fn hours_of_a_million_points_are_timed() {
    let Some(scene) = city() else { return };
    let tracer = Tracer::build(&scene, TraceOptions::default());
    for (name, points) in [("ground", ground(&scene, &tracer, 1e6)), ("surfaces", walls(&tracer, 1e6))] {
        for date in ["2026-03-20", "2026-06-21"] {
            let (hours, seconds) = timed(&day(date), &tracer, &points);
            let lit: f64 = (0..hours.len()).map(|point| hours.seconds(point)).sum();
            let spans: usize = (0..hours.len()).map(|point| hours.spans(point).len()).sum();
            println!(
                "{date}: {} points of the {name} in {seconds:.1} s, {spans} spans, {:.3} h in the mean",
                points.len(),
                lit / 3600.0 / points.len() as f64
            );
            assert!(lit > 0.0);
        }
    }
}
