//! Baked paths answer as rays do, at any moment.

use std::io::Cursor;
use std::ops::Range;
use std::sync::{Arc, mpsc};

use adumbra::stream::BytesSource;
use adumbra::{Filter, Sun};
use adumbra::{PathSampler, SunPath, SunStep};
use adumbra_bake::{BakeOptions, Size, Watch};
use adumbra_path::{
    BakedPath, Error, FollowOptions, Followed, PathOptions, SunFollower, bake_path, measure, visible_points,
};
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_truth::trace::{TraceOptions, Tracer};

/// Suns of an afternoon, every two minutes from `from` to `to` degrees of the hour angle, at the equinox and
/// 48° north.
fn afternoon(from: u32, to: u32) -> Vec<SunStep> {
    let (sin, cos) = 48_f64.to_radians().sin_cos();
    let step = |half_degree: u32| {
        let hour = (0.5 * f64::from(half_degree)).to_radians();
        let towards_sun = [-hour.sin(), cos * hour.cos(), sin * hour.cos()];
        SunStep { seconds: 120.0 * f64::from(half_degree), towards_sun }
    };
    (2 * from..=2 * to).map(step).collect()
}

fn options(resolution: u64) -> PathOptions {
    let sun = Sun::from_angles(0.0, 45.0).unwrap();
    PathOptions::new(BakeOptions::new(sun, Size::Resolution(resolution)))
}

fn opened(path: &BakedPath, steps: Vec<SunStep>) -> SunPath {
    let keys: Vec<(f64, Vec<u8>)> = path.keys.iter().map(|key| (key.seconds, key.bytes.clone())).collect();
    let mut bytes = Cursor::new(Vec::new());
    SunPath::write(&mut bytes, steps, &keys, 0, None).unwrap();
    SunPath::open(Arc::new(BytesSource(bytes.into_inner())), "day").unwrap()
}

fn city() -> Scene {
    generate(GeneratedKind::City, 5)
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn moments_between_keys_are_about_as_exact_as_keys() {
    moments_between_keys_are_right(&city(), &options(1024), 40, &(4..40), 5.0);
}

#[test]
fn moments_of_an_hour_are_about_as_exact_as_keys() {
    let scene = generate(GeneratedKind::Primitives, 1);
    // With this few points, some are wrong by chance, and the shadows of small solids pass over few points.
    let options = PathOptions { points: 5000, error_percent: 0.5, ..options(1024) };
    moments_between_keys_are_right(&scene, &options, 14, &(2..8), 1.5);
}

/// Bakes a path from noon to an hour angle in degrees, and checks the number of its keys. The excess of wrong
/// points with the nearest key alone must be at least `times` that between the keys.
fn moments_between_keys_are_right(
    scene: &Scene,
    options: &PathOptions,
    to: u32,
    keys: &Range<usize>,
    times: f64,
) {
    let steps = afternoon(0, to);
    let mut heard = 0;
    let baked = bake_path(scene, &steps, options, Watch::none(), |_| heard += 1).unwrap();
    let path = opened(&baked, steps.clone());
    assert_eq!((heard, path.key_seconds().len()), (baked.keys.len(), baked.keys.len()));
    assert_eq!((baked.keys[0].step, baked.keys[heard - 1].step), (0, steps.len() - 1));
    assert!(keys.contains(&heard), "{heard} keys");
    for key in baked.keys.iter().filter_map(|key| key.gap) {
        assert!(key.wrong_percent - key.own_percent <= options.error_percent, "{key:?}");
    }
    // All keys share their voxels.
    let grids: Vec<_> = (0..heard).map(|key| path.key(key).unwrap().grid).collect();
    assert!(grids.iter().all(|grid| grid.voxel_size == baked.voxel_size && grid.frame == grids[0].frame));

    let tracer = Tracer::build(scene, TraceOptions::default());
    let within = &steps[..steps.len() - 1];
    let moments: Vec<f64> = within.iter().step_by(5).map(|step| step.seconds + 30.0).collect();
    let measured = measure(&path, &tracer, options.points, moments.clone(), |_| ()).unwrap();
    assert_eq!(measured.len(), moments.len());
    let mean = |of: &dyn Fn(usize) -> f64| (0..measured.len()).map(of).sum::<f64>() / measured.len() as f64;
    let excess = mean(&|i| measured[i].wrong_percent - measured[i].own_percent);
    // The nearest key alone, as if the sun stood still.
    let points = visible_points(&tracer, 5000, 3);
    let still = mean(&|i| {
        let sun = path.sun_at(measured[i].seconds).unwrap();
        let nearest = path.keys_at(measured[i].seconds).unwrap()[0];
        let sampler = path.key(nearest).unwrap().sampler(Filter::Nearest);
        let facing = points.iter().filter(|point| point.faces(sun));
        let (mut all, mut wrong) = (0, 0);
        for point in facing {
            let lit = tracer.sun_visible(point.lifted_world, sun);
            all += 1;
            wrong += u32::from((sampler.visibility(point.p_world, Some(point.normal)) > 0.5) != lit);
        }
        100.0 * f64::from(wrong) / f64::from(all)
    });
    let own = mean(&|i| measured[i].own_percent);
    println!("{heard} keys; own {own:.3} %, between {excess:.3} more, nearest key {:.3} more", still - own);
    assert!(excess <= 2.0 * options.error_percent, "{excess}");
    assert!(still - own > times * excess.max(0.1), "{still}, {own}, {excess}");
}

#[test]
fn filter_is_mean_of_rays_and_quick_differs_at_passing_shadows() {
    let scene = city();
    let steps = afternoon(10, 18);
    let mut options = options(1024);
    options.error_percent = 100.0;
    let baked = bake_path(&scene, &steps, &options, Watch::none(), |_| ()).unwrap();
    assert_eq!(baked.keys.len(), 2, "any error is allowed");
    let path = opened(&baked, steps);
    let seconds = 120.0 * 28.0;
    let sun = path.sun_at(seconds).unwrap();
    let [a, b] = path.keys_at(seconds).unwrap().map(|key| path.key(key).unwrap());
    let sampler = |filter| PathSampler::new([&a, &b], sun, filter).unwrap();
    let (hard, soft) = (sampler(Filter::Nearest), sampler(Filter::Box9));
    let quick = hard.clone().quick();
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let (mut mixed, mut differing, mut far) = (0, 0, 0);
    let points = visible_points(&tracer, 20_000, 4);
    for point in points.iter().filter(|point| point.faces(sun)) {
        let look = |sampler: &PathSampler| sampler.look_up(point.p_world, Some(point.normal));
        let [hard, soft, quick] = [look(&hard), look(&soft), look(&quick)];
        assert!([0.0, 1.0].contains(&hard) && (0.0..=1.0).contains(&soft));
        assert!((9.0 * soft).fract().min(1.0 - (9.0 * soft).fract()) < 1e-5, "ninths: {soft}");
        mixed += u32::from(soft > 0.0 && soft < 1.0);
        far += u32::from((hard - soft).abs() > 0.99);
        differing += u32::from(quick != hard);
    }
    println!("{mixed} mixed, {far} far, {differing} differ of {}", points.len());
    assert!(mixed > 300 && far * 200 < points.len() as u32);
    assert!(differing > 0 && differing * 50 < points.len() as u32, "{differing}");
}

#[test]
fn rejects_path_without_high_sun_and_places_no_keys_at_night() {
    let scene = generate(GeneratedKind::Primitives, 1);
    let night: Vec<SunStep> = (0..5)
        .map(|i| SunStep { seconds: f64::from(i), towards_sun: [0.999_f64.sqrt(), -0.001_f64.sqrt(), 0.0] })
        .collect();
    let error = bake_path(&scene, &night, &options(256), Watch::none(), |_| ()).unwrap_err();
    assert!(matches!(error, Error::NoSun { .. }) && error.to_string().contains("never 3°"), "{error}");
    // Around a night there are two runs, each with keys at its ends.
    let mut steps = afternoon(0, 3);
    let day = steps.len();
    steps.extend((0..4).map(|i| SunStep { seconds: 2000.0 + f64::from(i), ..night[0] }));
    steps
        .extend(afternoon(0, 2).into_iter().map(|step| SunStep { seconds: step.seconds + 86_400.0, ..step }));
    let baked = bake_path(&scene, &steps, &options(256), Watch::none(), |_| ()).unwrap();
    let placed: Vec<usize> = baked.keys.iter().map(|key| key.step).collect();
    for end in [0, day - 1, day + 4, steps.len() - 1] {
        assert!(placed.contains(&end), "{placed:?}");
    }
    assert!(placed.iter().all(|&step| steps[step].towards_sun[1] > 0.0));
    let path = opened(&baked, steps);
    assert_eq!((path.sun_at(2001.0), path.keys_at(2001.0)), (None, None));
}

#[test]
fn keys_stay_apart_where_closer_keys_do_not_help() {
    // Near the zenith, at midsummer and 20° north, and with large voxels: there, even a short march is worse
    // than a file by more than the allowed error.
    let step = |minute: u32| {
        let (latitude, declination) = (20_f64.to_radians(), 23.44_f64.to_radians());
        let hour = (0.25 * f64::from(minute) - 7.5).to_radians();
        let east = -declination.cos() * hour.sin();
        let up = latitude.sin() * declination.sin() + latitude.cos() * declination.cos() * hour.cos();
        let north = latitude.cos() * declination.sin() - latitude.sin() * declination.cos() * hour.cos();
        SunStep { seconds: 60.0 * f64::from(minute), towards_sun: [east, up, -north] }
    };
    let steps: Vec<SunStep> = (0..=10).map(step).collect();
    let scene = generate(GeneratedKind::City, 1);
    let options = PathOptions { points: 10_000, ..options(512) };
    let baked = bake_path(&scene, &steps, &options, Watch::none(), |_| {}).unwrap();
    let keys: Vec<usize> = baked.keys.iter().map(|key| key.step).collect();
    println!("{keys:?}");
    assert!(keys.len() <= 5, "{keys:?}");
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn follower_bakes_ahead_and_answers_as_rays_do() {
    a_follower_answers_as_rays_do(generate(GeneratedKind::City, 1), 2048, 300, 60);
}

#[test]
fn follower_of_small_scene_bakes_ahead_and_answers_as_rays_do() {
    a_follower_answers_as_rays_do(generate(GeneratedKind::Primitives, 1), 1024, 100, 25);
}

/// Follows a sun for `frames` frames, and compares every `every`-th with rays.
fn a_follower_answers_as_rays_do(scene: Scene, resolution: u64, frames: u32, every: u32) {
    let scene = Arc::new(scene);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let points = visible_points(&tracer, 2000, 3);
    let first = Sun::from_angles(120.0, 35.0).unwrap();
    let options = FollowOptions::new(BakeOptions::new(first, Size::Resolution(resolution)));
    let (woken, wakes) = mpsc::channel();
    let mut follower = SunFollower::start(Arc::clone(&scene), options, move || _ = woken.send(())).unwrap();
    // The sun moves half a degree per second, at ten frames per second. The clock stops while a needed key is
    // baked.
    let mut changes = 0;
    for frame in 0..frames {
        let seconds = f64::from(frame) / 10.0;
        let sun = Sun::from_angles(120.0 + 0.5 * seconds, 35.0 + 0.1 * seconds).unwrap().towards();
        let mut followed = follower.follow(seconds, sun);
        while matches!(followed, Followed::Waiting) || (frame == 0 && follower.is_baking()) {
            wakes.recv().unwrap();
            followed = follower.follow(seconds, sun);
        }
        if frame % 10 == 0 && follower.is_baking() {
            // Wait, so that no bake takes longer than ten frames.
            wakes.recv().unwrap();
        }
        let Followed::Moment(moment) = followed else { panic!("{followed:?}") };
        assert!(moment.changes >= changes && moment.towards_sun == sun);
        changes = moment.changes;
        if frame % every == every - 1 {
            let sampler = moment.sampler(Filter::Nearest);
            let facing: Vec<_> = points.iter().filter(|point| point.faces(sun)).collect();
            let wrong = facing.iter().filter(|point| {
                let lit = sampler.look_up(point.p_world, Some(point.normal)) > 0.5;
                lit != tracer.sun_visible(point.lifted_world, sun)
            });
            let percent = 100.0 * wrong.count() as f64 / facing.len() as f64;
            println!("{seconds} s: {percent:.2} % wrong, {}× coarser", moment.coarser);
            assert!(percent < 2.0, "{percent}");
        }
    }
    assert!(changes >= 3, "{changes}");
    assert!(matches!(follower.follow(f64::from(frames) / 10.0 + 1.0, [0.8, -0.6, 0.0]), Followed::Night));
    assert!(follower.take_fault().is_none());
    // A stopped follower does not bake for another sun.
    while follower.is_baking() {
        wakes.recv().unwrap();
        _ = follower.follow(f64::from(frames) / 10.0 + 1.0, [0.8, -0.6, 0.0]);
    }
    follower.stop();
    let elsewhere = Sun::from_angles(300.0, 60.0).unwrap().towards();
    _ = follower.follow(f64::from(frames) / 10.0 + 2.0, elsewhere);
    assert!(!follower.is_baking());
}
