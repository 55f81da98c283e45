//! `adumbra bake --sun-path` and `--suns`: bakes the path of a sun.

use std::time::Instant;

use adumbra::{IoError, Sun, SunPath, SunStep};
use adumbra_bake::Watch;
use adumbra_files::{self as files, StagedFile, TEXT_BYTES, read_text};
use adumbra_path::{BakedKey, BakedPath, Error, GapError, PathOptions, bake_path};
use adumbra_program::exit::Failure;
use adumbra_program::glance::look;
use adumbra_program::moment::{clock, steps_of, suns_of_day};
use adumbra_program::output::format_bytes;
use adumbra_program::say;
use adumbra_program::scene::load_scene_within;
use adumbra_program::threads::with_threads;
use adumbra_solar::{Day, read_suns};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Bake;
use crate::cmd::ground::DecidedGround;
use crate::cmd::path::say_hidden;

/// The result of a path's bake.
#[derive(Serialize, JsonSchema)]
pub(in crate::cmd) struct BakedSunPath {
    /// The sun path that was written.
    file: String,
    /// Total wall time: loading, baking and writing.
    seconds: f64,
    /// Length of the file, in bytes.
    file_bytes: u64,
    /// Bytes of the largest two keys that follow each other once decoded: what a reader holds at a time.
    resident_bytes: u64,
    /// Edge of the finest voxels, world units.
    voxel_size: f64,
    /// For how many voxels a ray must be hidden from both keys to be taken to meet something; 0 = never.
    dark_after_voxels: u32,
    /// Number of steps of the sun.
    steps: usize,
    /// Whether shadows below the last surface of a column are left out.
    assumes_ground: bool,
    /// The keys, in the order of time.
    keys: Vec<Key>,
}

/// A key of a path.
#[derive(Serialize, JsonSchema)]
pub(in crate::cmd) struct Key {
    /// Its moment, in the path's seconds.
    seconds: f64,
    /// Elevation of its sun, degrees.
    elevation_degrees: f64,
    /// Bytes of its shadow file.
    file_bytes: u64,
    /// Bytes of its words once decoded.
    raw_bytes: u64,
    /// Share of visible points that are wrong half way to the key before it, in percent; null for the first
    /// one, and where no step is between them.
    wrong_percent: Option<f64>,
    /// The same share in the two keys at their own suns, the mean.
    own_percent: Option<f64>,
}

/// The suns of a path.
struct Suns {
    steps: Vec<SunStep>,
    utc_offset_seconds: i32,
    place_degrees: Option<[f64; 2]>,
}

/// Bakes a path if one was asked for.
pub(super) fn run(args: &Bake) -> Option<Result<BakedSunPath, Failure>> {
    let suns = match (&args.path.sun_path, &args.path.suns) {
        (Some(day), _) => of_day(day),
        (None, Some(path)) => of_list(path),
        (None, None) => return None,
    };
    Some(suns.and_then(|suns| bake(args, suns)))
}

fn of_day(day: &Day) -> Result<Suns, Failure> {
    let usage = |error: adumbra_solar::Error| Failure::Usage(format!("--sun-path: {error}"));
    let (steps, utc_offset_seconds) = suns_of_day(day).map_err(usage)?;
    let place_degrees = Some([day.location.latitude_degrees(), day.location.longitude_degrees()]);
    Ok(Suns { steps, utc_offset_seconds, place_degrees })
}

fn of_list(path: &std::path::Path) -> Result<Suns, Failure> {
    let text = read_text(path, TEXT_BYTES)?;
    let bad = |error: adumbra_solar::Error| Failure::BadInput(format!("{}: {error}", path.display()));
    let steps = steps_of(&read_suns(&text).map_err(bad)?);
    Ok(Suns { steps, utc_offset_seconds: 0, place_degrees: None })
}

fn bake(args: &Bake, suns: Suns) -> Result<BakedSunPath, Failure> {
    let start = Instant::now();
    let range = |option: &str, value: f64, expected: &str| {
        Err(Failure::Usage(format!("{option} {value}: give {expected}")))
    };
    let (error_percent, lowest_degrees) = (args.path.path_error, args.path.lowest_sun);
    if !(error_percent > 0.0 && error_percent <= 100.0) {
        return range("--path-error", error_percent, "a share in percent, above 0 and at most 100");
    }
    if !(0.5..90.0).contains(&lowest_degrees) {
        return range("--lowest-sun", lowest_degrees, "an elevation from 0.5 to below 90 degrees");
    }
    let output = args.output.clone().unwrap_or_else(|| args.scene.with_extension("day.adumbra"));
    args.check_paths(&output)?;
    files::check_output(&output)?;
    let (ground, baked) = with_threads(args.run.threads, || -> Result<_, Failure> {
        let limit = args.run.memory_limit();
        let scene = load_scene_within(limit, &args.scene, &args.load.load_options()?)?;
        let share = limit.share(scene.memory_bytes());
        let sun = Sun::from_angles(0.0, 45.0)?;
        let mut bake = args.settings.options(sun, args.load.ignore_alpha);
        bake.max_memory_bytes = share.bytes();
        let ground = DecidedGround::of(&scene, &mut bake);
        let height = |step: &&SunStep| step.towards_sun[1];
        if let Some(highest) = suns.steps.iter().max_by(|a, b| height(a).total_cmp(&height(b))) {
            let sun = Sun::from_direction(highest.towards_sun).unwrap_or(sun);
            look(&scene, &args.scene, sun, bake.ignore_alpha);
        }
        let options = PathOptions { error_percent, lowest_degrees, ..PathOptions::new(bake) };
        let on_key = |key: &BakedKey| {
            if !args.run.json {
                say!("{}", line(&suns, key));
            }
        };
        let baked = bake_path(&scene, &suns.steps, &options, Watch::none(), on_key);
        Ok((ground, baked.map_err(|error| failure(error, &output))?))
    })??;
    let BakedPath { keys, voxel_size, dark_after_voxels } = baked;
    let resident_bytes =
        keys.windows(2).map(|pair| pair[0].raw_bytes + pair[1].raw_bytes).max().unwrap_or(keys[0].raw_bytes);
    let shown = keys.iter().map(|key| shown(&suns, key)).collect();
    let bodies: Vec<(f64, Vec<u8>)> = keys.into_iter().map(|key| (key.seconds, key.bytes)).collect();
    let steps = suns.steps.len();
    let mut file_bytes = 0;
    let staged = StagedFile::new(&output, |out| {
        file_bytes = SunPath::write(out, suns.steps, &bodies, suns.utc_offset_seconds, suns.place_degrees)?;
        Ok(file_bytes)
    })?;
    StagedFile::place([staged])?;
    let seconds = start.elapsed().as_secs_f64();
    let baked = BakedSunPath {
        file: output.display().to_string(),
        seconds,
        file_bytes,
        resident_bytes,
        voxel_size,
        dark_after_voxels,
        steps,
        assumes_ground: ground.is_assumed,
        keys: shown,
    };
    if !args.run.json {
        say!(
            "{} -> {} ({} keys, {}, {} in memory at a time) in {seconds:.1} s",
            args.scene.display(),
            output.display(),
            baked.keys.len(),
            format_bytes(file_bytes),
            format_bytes(resident_bytes)
        );
        say!("  {ground}");
        say_hidden(dark_after_voxels, voxel_size);
    }
    Ok(baked)
}

fn elevation_degrees(suns: &Suns, key: &BakedKey) -> f64 {
    suns.steps[key.step].towards_sun[1].asin().to_degrees()
}

fn shown(suns: &Suns, key: &BakedKey) -> Key {
    Key {
        seconds: key.seconds,
        elevation_degrees: elevation_degrees(suns, key),
        file_bytes: key.bytes.len() as u64,
        raw_bytes: key.raw_bytes,
        wrong_percent: key.gap.map(|gap| gap.wrong_percent),
        own_percent: key.gap.map(|gap| gap.own_percent),
    }
}

fn line(suns: &Suns, key: &BakedKey) -> String {
    let gap = match key.gap {
        Some(GapError { wrong_percent, own_percent, .. }) => {
            format!(", half way before it {wrong_percent:.2} % wrong, {own_percent:.2} % at the keys")
        }
        None => String::new(),
    };
    let time = clock(key.seconds, suns.utc_offset_seconds, suns.place_degrees.is_some());
    let bytes = format_bytes(key.bytes.len() as u64);
    format!("  {time}  sun {:.1}° high, {bytes}{gap}", elevation_degrees(suns, key))
}

fn failure(error: Error, output: &std::path::Path) -> Failure {
    match error {
        Error::Write(error) => IoError::at("write", output)(error).into(),
        other => other.into(),
    }
}
