//! Sun paths in place of shadow files: in `query`, `verify` and `info`.

use std::path::Path;

use adumbra::{FileSettings, Filter, PathSampler, SunPath};
use adumbra_html::plot::{Along, Legend, Panel, Series, write_svg};
use adumbra_path::{Moment, measure};
use adumbra_program::exit::{Failure, Outcome};
use adumbra_program::moment::{PathMoment, TimeArg, moment, path_moment, shown, span};
use adumbra_program::output::{SCENE, format_bytes, refuse_inputs};
use adumbra_program::query::Query;
use adumbra_program::say;
use adumbra_program::scene::load_scene_within;
use adumbra_program::threads::with_threads;
use adumbra_program::verify::{Verify, remedy, warn_of_other_casters};
use adumbra_scene::{Casters, LoadedAs};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::LightAnswers;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::VerifyPathArgs;

/// Points at which each moment is compared with rays. With this many, a moment's shares are accurate to about
/// 0.02 percentage points.
const POINTS: usize = 100_000;

/// What a sun path contains.
#[derive(Serialize, JsonSchema)]
pub(super) struct PathInfo {
    /// The sun path.
    file: String,
    /// Length of the file, in bytes.
    file_bytes: u64,
    /// Latitude and longitude in degrees, north and east positive; null of suns that were listed.
    place_degrees: Option<[f64; 2]>,
    /// How far the local clock is ahead of UTC, seconds.
    utc_offset_seconds: i32,
    /// Number of steps of the sun.
    steps: usize,
    /// The first and the last step, seconds.
    span_seconds: [f64; 2],
    /// Moments of the keys, seconds.
    key_seconds: Vec<f64>,
    /// Elevations of the keys' suns, degrees.
    key_elevation_degrees: Vec<f64>,
}

/// A path that was compared with rays.
#[derive(Serialize, JsonSchema)]
pub(super) struct VerifiedPath {
    /// The sun path.
    file: String,
    /// Mean share of the points that were wrong, percent.
    mean_wrong_percent: f64,
    /// Mean share of the points that the keys have wrong at their own suns, percent.
    mean_own_percent: f64,
    /// The largest difference of the two at a moment, percent.
    max_excess_percent: f64,
    /// Whether the middle key keeps the promises of a shadow file, and the mean is as good as was asked for.
    pub(super) ok: bool,
    /// The moments.
    moments: Vec<VerifiedMoment>,
}

/// A moment that was compared with rays.
#[derive(Serialize, JsonSchema)]
pub(super) struct VerifiedMoment {
    /// The moment, seconds.
    seconds: f64,
    /// Elevation of the sun, degrees.
    elevation_degrees: f64,
    /// Share of the visible points that face the sun whose answer is not that of rays, percent.
    wrong_percent: f64,
    /// The same share of the keys around at their own suns, percent.
    own_percent: f64,
}

/// Prints over which depth both keys must hide a ray to block it, if the path has such a depth.
pub(super) fn say_hidden(dark_after_voxels: u32, voxel_size: f64) {
    if dark_after_voxels > 0 {
        let depth_world = f64::from(dark_after_voxels) * voxel_size;
        say!(
            "  rays that no key knows are blocked if both hide them over a depth of {depth_world:.3} world units or more"
        );
    }
}

/// Looks points up at a moment.
pub(super) fn query(args: &Query, path: &SunPath, time: Option<TimeArg>, level: u32) -> Outcome {
    let file = args.file.display();
    let Some(time) = time else {
        return Err(Failure::Usage(format!(
            "{file} is a sun path; give a moment with --time, such as 12:30"
        )));
    };
    if level != 0 {
        return Err(Failure::Usage(format!(
            "--level {level}: {file} is a sun path, which answers from level 0"
        )));
    }
    let seconds = moment(path, "--time", time)?;
    let filter = Filter::try_from(args.lookup.filter)?;
    let answering = path_moment(path, seconds, args.run.memory_limit())?;
    let points = args.read()?;
    let Some(PathMoment { sun, keys }) = answering else {
        let time = shown(path, seconds);
        adumbra_program::note!("warning: at {time} the sun is below the horizon: all points are in shadow");
        return args.answer(&points, &Night, None);
    };
    let bias = args.lookup.bias.over(keys[0].settings.bias)?;
    let Some(sampler) = PathSampler::new(keys.each_ref(), sun.towards(), filter) else {
        let time = shown(path, seconds);
        return Err(Failure::BadInput(format!("{file}: at {time} the sun is too far from the nearest key")));
    };
    args.answer(&points, &sampler.with_bias(bias)?, None)
}

/// A time at which no point sees the sun.
struct Night;

impl adumbra::PointVisibility for Night {
    fn visibility(&self, _: [f64; 3], _: Option<[f64; 3]>) -> f32 {
        0.0
    }
}

/// Compares a path with rays, and prints the result.
pub(super) fn verify(
    args: &Verify,
    of_path: &VerifyPathArgs,
    path: &SunPath,
) -> Result<VerifiedPath, Failure> {
    if !(of_path.max_excess >= 0.0) {
        return Err(Failure::Usage(format!("--max-excess {}: give 0 or more percent", of_path.max_excess)));
    }
    if let Some(plot) = &of_path.plot {
        refuse_inputs("--plot", plot, [("the sun path", &*args.file), (SCENE, &*args.scene)])?;
        adumbra_files::check_output(plot)?;
    }
    let mut load = args.load.load_options()?;
    args.run.memory_limit().check_keys(path)?;
    load.follow(LoadedAs::from(&path.key(0)?.settings), &args.scene);
    let ignore_alpha = load.ignore_alpha;
    let scene = load_scene_within(args.run.memory_limit(), &args.scene, &load)?;
    let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha });
    let moments = path.steps().iter().step_by(of_path.every as usize).map(|step| step.seconds);
    let on_moment = |moment: &Moment| {
        if !args.run.json {
            let Moment { seconds, elevation_degrees, wrong_percent, own_percent } = *moment;
            say!(
                "  {}  sun {elevation_degrees:.1}° high, {wrong_percent:.2} % wrong, {own_percent:.2} % at the keys",
                shown(path, seconds)
            );
        }
    };
    let measured = with_threads(args.run.threads, || measure(path, &tracer, POINTS, moments, on_moment))??;
    if measured.is_empty() {
        return Err(Failure::BadInput(format!("{}: no sun of the path is up", args.file.display())));
    }
    let mean = |of: fn(&Moment) -> f64| measured.iter().map(of).sum::<f64>() / measured.len() as f64;
    let [wrong, own] = [mean(|m| m.wrong_percent), mean(|m| m.own_percent)];
    let max_excess = measured.iter().map(|m| m.wrong_percent - m.own_percent).fold(f64::MIN, f64::max);
    if let Some(plot) = &of_path.plot {
        write_plot(plot, &measured)?;
    }
    // A path of another scene is as wrong at its keys as between them, so verify a key too.
    let key = path.key(path.key_seconds().len() / 2)?;
    let answers = LightAnswers::of(&key, key.sampler(Filter::Nearest));
    let of_key =
        with_threads(args.run.threads, || args.trace(&scene, ignore_alpha, key.sun(), None, &answers))??;
    let key_holds = of_key.is_checked() && of_key.holds();
    let ok = key_holds && wrong - own <= of_path.max_excess;
    if !args.run.json {
        let limit = of_path.max_excess;
        say!(
            "{}: {wrong:.3} % wrong on the mean, {own:.3} % at the keys; at most {max_excess:.2} points more at a moment",
            args.file.display()
        );
        say!("{}: the mean may have {limit} points more than the keys", if ok { "ok" } else { "FAILED" });
    }
    let FileSettings { triangles, instances, .. } = key.settings;
    let (baked, casters) = (Casters { triangles, instances }, scene.casters());
    warn_of_other_casters(baked, casters);
    if !key_holds {
        let remedy = remedy(&of_key, baked == casters);
        adumbra_program::note!("check failed: the middle key misses what a shadow file promises; {remedy}");
    }
    Ok(VerifiedPath {
        file: args.file.display().to_string(),
        mean_wrong_percent: wrong,
        mean_own_percent: own,
        max_excess_percent: max_excess,
        ok,
        moments: measured.iter().map(verified).collect(),
    })
}

fn verified(moment: &Moment) -> VerifiedMoment {
    let Moment { seconds, elevation_degrees, wrong_percent, own_percent } = *moment;
    VerifiedMoment { seconds, elevation_degrees, wrong_percent, own_percent }
}

fn write_plot(plot: &Path, moments: &[Moment]) -> Result<(), Failure> {
    let first = moments.first().map_or(0.0, |moment| moment.seconds);
    let series = |name: &str, of: fn(&Moment) -> f64| Series {
        name: name.to_owned(),
        points: moments.iter().map(|m| ((m.seconds - first) / 3600.0, of(m))).collect(),
    };
    let panel = |title: &str, y_label, series| Panel {
        title: title.to_owned(),
        along: Along::Numbers("hours"),
        y_label,
        logarithmic: false,
        legend: Legend::UpperRight,
        series,
    };
    let wrong =
        vec![series("between the keys", |m| m.wrong_percent), series("at the keys", |m| m.own_percent)];
    let sun = vec![series("sun", |m| m.elevation_degrees)];
    let panels = [panel("Wrong points", "percent", wrong), panel("Elevation", "degrees", sun)];
    write_svg(plot, &panels)
}

/// Returns what a path contains.
pub(super) fn info(path: &SunPath, file: &Path, json: bool) -> Result<Option<PathInfo>, Failure> {
    let elevation = |seconds: &f64| path.sun_at(*seconds).map_or(0.0, |sun| sun[1].asin().to_degrees());
    let key_seconds = path.key_seconds();
    let info = PathInfo {
        file: file.display().to_string(),
        file_bytes: path.file_bytes(),
        place_degrees: path.place_degrees(),
        utc_offset_seconds: path.utc_offset_seconds(),
        steps: path.steps().len(),
        span_seconds: span(path),
        key_elevation_degrees: key_seconds.iter().map(elevation).collect(),
        key_seconds,
    };
    if json {
        return Ok(Some(info));
    }
    let [from, to] = info.span_seconds.map(|seconds| shown(path, seconds));
    say!("{}: the path of a sun, {}", info.file, format_bytes(info.file_bytes));
    if let Some([latitude, longitude]) = info.place_degrees {
        say!("  place     latitude {latitude}°, longitude {longitude}°");
    }
    say!("  time      {from} to {to}, {} steps", info.steps);
    say!("  keys      {}", info.key_seconds.len());
    for (index, (seconds, elevation)) in info.key_seconds.iter().zip(&info.key_elevation_degrees).enumerate()
    {
        let key = path.key(index)?;
        let [x, y, z] = key.grid.size;
        let raw = format_bytes(key.encoded_len());
        if index == 0 {
            say_hidden(key.settings.dark_after_voxels, key.grid.voxel_size);
        }
        say!(
            "    {}  sun {elevation:.1}° high, {x} x {y} x {z} voxels, {raw} decoded",
            shown(path, *seconds)
        );
    }
    Ok(None)
}
