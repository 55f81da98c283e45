//! `adumbra sun-hours`: how long points see the sun.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::output::{Outputs, png, print_json};
use adumbra_program::say;
use adumbra_program::threads::with_threads;
use adumbra_scene::Scene;
use adumbra_solar::Day;
use adumbra_sunlight::{Suns, Watch};
use schemars::JsonSchema;
use serde::Serialize;

use super::format::{Format, outputs};
use super::geotiff::MapPlace;
use super::json::HoursFile;
use super::picture::Legend;
use super::traced::{HOUR_SECONDS, Traced};
use super::{csv, geotiff, page, picture, ply, study};
use crate::args::SunHours;

/// The result of `sun-hours`.
#[derive(Serialize, JsonSchema)]
pub(in crate::cmd) struct SunHoursFound {
    /// The files that were written.
    outputs: Vec<String>,
    /// Number of points.
    points: usize,
    /// How long the sun is above the horizon, hours.
    most_hours: f64,
    /// Mean hours of sun of the points.
    mean_hours: f64,
    /// Hours of sun of the point that has the fewest.
    least_hours: f64,
    /// Hours of sun of the point that has the most.
    largest_hours: f64,
    /// Mean hours of sun of the other design. Null without `--compare`.
    other_mean_hours: Option<f64>,
    /// Wall time of tracing towards suns.
    trace_seconds: f64,
    /// Total wall time: loading, tracing and writing.
    seconds: f64,
}

pub(in crate::cmd) fn run(args: &SunHours) -> Outcome {
    let start = Instant::now();
    let accepted = if args.points.places.grid.is_some() { Format::OF_GRIDS } else { Format::OF_POINTS };
    let scenes: Vec<&Path> = [&*args.scene].into_iter().chain(args.compare.as_deref()).collect();
    let formats = outputs(&args.output, accepted, &scenes, &args.points)?;
    if args.compare.is_some() && !formats.iter().any(|(_, format)| *format == Format::Html) {
        return Err(Failure::Usage("--compare needs a page to compare on; give -o FILE.html".to_owned()));
    }
    let day = args.day.day()?;
    let arcs = day.arcs().map_err(|error| Failure::Usage(format!("{error} (--date, --from, --to)")))?;
    let suns = Suns::new(&arcs);
    with_threads(args.run.threads, || {
        let run = Run { args, day: &day, suns: &suns };
        let scene = study::load(&args.scene, &args.load, &args.run)?;
        let other = args.compare.as_ref().map(|path| study::load(path, &args.load, &args.run)).transpose()?;
        let both: Vec<&Scene> = [&scene].into_iter().chain(&other).collect();
        let (traced, mut trace_seconds) = run.trace(&scene, &both)?;
        let other = other.as_ref().map(|other| run.trace(other, &both)).transpose()?;
        trace_seconds += other.as_ref().map_or(0.0, |(_, seconds)| *seconds);
        let other = other.map(|(traced, _)| traced);
        args.run.memory_limit().check_peak("the hours of the points")?;
        let mut files = Outputs::default();
        for (path, format) in &formats {
            files.add(path, &run.bytes(path, *format, &traced, other.as_ref())?)?;
        }
        files.place()?;
        let [mean_hours, least_hours, largest_hours] = traced.spread();
        let found = SunHoursFound {
            outputs: args.output.iter().map(|path| path.display().to_string()).collect(),
            points: traced.hours.len(),
            most_hours: traced.most_hours,
            mean_hours,
            least_hours,
            largest_hours,
            other_mean_hours: other.as_ref().map(|other| other.spread()[0]),
            trace_seconds,
            seconds: start.elapsed().as_secs_f64(),
        };
        if args.run.json {
            print_json(&found)?;
        } else {
            found.say(&args.scene, &traced);
        }
        Ok(Code::Fine)
    })?
}

impl SunHoursFound {
    fn say(&self, scene: &Path, traced: &Traced) {
        say!("{}: {} points, {}", scene.display(), self.points, traced.when());
        say!("  sun above the horizon  {:.2} h", self.most_hours);
        say!(
            "  hours of sun           mean {:.2}, least {:.2}, most {:.2}",
            self.mean_hours,
            self.least_hours,
            self.largest_hours
        );
        if let Some(mean) = self.other_mean_hours {
            say!("  the other design       mean {mean:.2}");
        }
        say!("  traced in              {:.1} s", self.trace_seconds);
        self.outputs.iter().for_each(|output| say!("  -> {output}"));
    }
}

/// The inputs that both designs share.
struct Run<'a> {
    args: &'a SunHours,
    day: &'a Day,
    suns: &'a Suns,
}

impl Run<'_> {
    /// Traces one of the scenes. Also returns the seconds that the rays towards suns took.
    fn trace(&self, scene: &Scene, both: &[&Scene]) -> Result<(Traced, f64), Failure> {
        let args = self.args;
        let tracer = study::tracer(scene, &args.load, &args.run)?;
        let points = study::points(&args.points, &tracer, args.load.ignore_alpha, both)?;
        args.run.memory_limit().check_peak("the points")?;
        let begun = Instant::now();
        let progress = study::reporter(args.progress);
        let cancel = AtomicBool::new(false);
        let watch = Watch::new(&progress, &cancel);
        let hours = self.suns.hours(&tracer, &points.receivers, watch);
        let hours = hours.map_err(|error| study::failure(&error, "--date"))?;
        let traced = Traced {
            points,
            hours,
            day: self.day.clone(),
            zone: self.day.zone(),
            most_hours: self.suns.seconds() / HOUR_SECONDS,
        };
        Ok((traced, begun.elapsed().as_secs_f64()))
    }

    /// Returns the bytes of an output.
    fn bytes(
        &self,
        path: &Path,
        format: Format,
        traced: &Traced,
        other: Option<&Traced>,
    ) -> Result<Vec<u8>, Failure> {
        let cannot = |what: String| Failure::BadInput(format!("{}: {what}", path.display()));
        let grid = || cannot("it needs --grid".to_owned());
        match format {
            Format::Csv => Ok(csv::hours(traced).into_bytes()),
            Format::Ply => Ok(ply::hours(traced)),
            Format::Json => serde_json::to_vec(&HoursFile::new(&self.args.scene, traced))
                .map_err(|error| cannot(error.to_string())),
            Format::Png => {
                let (grid, cells) = traced.cells().ok_or_else(grid)?;
                let legend = Legend::Hours(traced.most_hours);
                let picture = picture::draw(&cells, grid.size, &traced.when(), legend);
                png(path, &picture)
            }
            Format::Tiff => {
                let place = MapPlace { epsg: self.args.epsg, origin: self.args.origin };
                let bytes = geotiff::hours(traced, place).ok_or_else(grid)?;
                bytes.map_err(|error| cannot(error.to_string()))
            }
            Format::Html => {
                let name = |path: &Path| {
                    path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
                };
                let names =
                    [name(&self.args.scene), self.args.compare.as_deref().map(name).unwrap_or_default()];
                let text = page::html(path, [&names[0], &names[1]], traced, other).ok_or_else(grid)??;
                Ok(text.into_bytes())
            }
        }
    }
}
