//! Follows a sun in real time, 60 times a second, and compares the current shadows with rays every two
//! seconds.
//!
//! `cargo run --release -p adumbra-compare --example follow -- SCENE RESOLUTION SECONDS FIRST_ELEVATION
//! PLOT.svg [NEAR]` plays a day of 48 minutes: the sun rises by 7.5° a minute on a great circle that is 60°
//! high at noon. It prints CSV, then a summary, and plots errors over time. Rays, like bakes, take one
//! thread. A camera walks from the middle of the scene at 2 units a second. With NEAR, in world units, keys
//! cover a box around the camera, and only points within half of NEAR of the camera are compared.

use std::path::Path;
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use adumbra::{Filter, PointVisibility, Sun};
use adumbra_bake::{BakeOptions, Size};
use adumbra_html::plot::{Along, Legend, Panel, Series, write_svg};
use adumbra_path::{FollowOptions, Followed, FollowedMoment, SunFollower, VisiblePoint, visible_points};
use adumbra_scene::{LoadOptions, load};
use adumbra_truth::trace::{TraceOptions, Tracer};

/// Number of points to compare.
const POINTS: usize = 5000;

/// Returns the direction towards the sun at an angle along its circle.
fn sun(degrees: f64) -> [f64; 3] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (up, south) = 60f64.to_radians().sin_cos();
    [cos, sin * up, sin * south]
}

/// Returns the percentage of the points facing the sun whose answer differs from that of a ray.
fn wrong_percent(
    tracer: &Tracer<'_>,
    points: &[VisiblePoint],
    towards: [f64; 3],
    answers: &dyn PointVisibility,
) -> f64 {
    let facing: Vec<_> = points.iter().filter(|point| point.faces(towards)).collect();
    let is_wrong = |point: &&&VisiblePoint| {
        let lit = answers.visibility(point.p_world, Some(point.normal)) > 0.5;
        lit != tracer.sun_visible(point.lifted_world, towards)
    };
    100.0 * facing.iter().filter(is_wrong).count() as f64 / facing.len().max(1) as f64
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (Some([scene, resolution, seconds, elevation, plot]), near) = (words.first_chunk(), words.get(5))
    else {
        return Err(
            "give a scene, a resolution, seconds, the elevation to begin with, and a file for the plot"
                .into(),
        );
    };
    let near_world: Option<f64> = near.map(|near| near.parse()).transpose()?;
    let (seconds, elevation): (f64, f64) = (seconds.parse()?, elevation.parse()?);
    let first = (elevation.to_radians().sin() / 60f64.to_radians().sin()).asin().to_degrees();
    let scene = Arc::new(load(scene.as_ref(), &LoadOptions::default())?);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let bounds = scene.bounds();
    let middle = |axis: usize| 0.5 * (bounds.min[axis] + bounds.max[axis]);
    let camera = |seconds: f64| [middle(0) + 2.0 * seconds, 0.0, middle(2)];
    let is_near = |point: &VisiblePoint, camera: [f64; 3]| {
        let [x, _, z] = std::array::from_fn(|a| point.p_world[a] - camera[a]);
        near_world.is_none_or(|near| x.abs().max(z.abs()) < 0.5 * near)
    };
    // Compare as many points in a part of the scene as in the whole scene.
    let share = near_world.map_or(1.0, |near| (near / (bounds.max[0] - bounds.min[0])).powi(2));
    let points = visible_points(&tracer, ((POINTS as f64 / share) as usize).min(500_000), 1);
    let size = Size::Resolution(resolution.parse()?);
    let bake = BakeOptions::new(Sun::from_direction(sun(first))?, size);
    let options = FollowOptions { near_world, ..FollowOptions::new(bake) };
    let mut follower = SunFollower::start(Arc::clone(&scene), options, || {})?;
    println!("seconds,elevation_degrees,coarser,changes,wrong_percent");
    let (mut calls, mut unshadowed, mut wrong) = (Vec::new(), 0, Vec::new());
    let begin = Instant::now();
    let mut compared = 0.0;
    while begin.elapsed().as_secs_f64() < seconds {
        let now = begin.elapsed().as_secs_f64();
        let towards = sun(first + 0.125 * now);
        let call = Instant::now();
        follower.set_focus(camera(now));
        let followed = follower.follow(now, towards);
        calls.push(call.elapsed());
        if let Some(fault) = follower.take_fault() {
            return Err(fault.into());
        }
        match followed {
            Followed::Moment(moment) if now - compared >= 2.0 => {
                compared = now;
                let FollowedMoment { coarser, changes, towards_sun, .. } = moment;
                let seen: Vec<_> =
                    points.iter().filter(|point| is_near(point, camera(now))).copied().collect();
                let percent = wrong_percent(&tracer, &seen, towards_sun, &moment.sampler(Filter::Nearest));
                let elevation = towards[1].asin().to_degrees();
                println!("{now:.1},{elevation:.2},{coarser},{changes},{percent:.3}");
                wrong.push((now, coarser, percent));
            }
            Followed::Moment(_) => {}
            Followed::Night | Followed::Waiting => unshadowed += 1,
        }
        sleep(Duration::from_micros(16_667).saturating_sub(call.elapsed()));
    }
    calls.sort();
    let at_stage = |is_finest: bool| {
        let of_stage = wrong.iter().filter(move |(_, coarser, _)| (*coarser == 1) == is_finest);
        of_stage.map(|&(seconds, _, percent)| (seconds, percent)).collect::<Vec<_>>()
    };
    let series = [("coarse keys", false), ("finest keys", true)]
        .map(|(name, is_finest)| Series { name: name.to_owned(), points: at_stage(is_finest) });
    let panel = Panel {
        title: format!("Following a sun from {elevation}°"),
        along: Along::Numbers("seconds"),
        y_label: "wrong points, %",
        logarithmic: true,
        legend: Legend::UpperRight,
        series: series.into_iter().filter(|series| !series.points.is_empty()).collect(),
    };
    write_svg(Path::new(plot), &[panel])?;
    let fine = at_stage(true);
    eprintln!(
        "{} calls, median {:?}, longest {:?}; {unshadowed} without a key; {} of {} comparisons at the finest stage, {:.3} % wrong on the mean",
        calls.len(),
        calls[calls.len() / 2],
        calls[calls.len() - 1],
        fine.len(),
        wrong.len(),
        fine.iter().map(|(_, percent)| percent).sum::<f64>() / fine.len().max(1) as f64
    );
    Ok(())
}
