//! `adumbra sky`: which patches of the sky points see.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::output::{Outputs, print_json};
use adumbra_program::say;
use adumbra_program::threads::with_threads;
use adumbra_sunlight::{Patches, Watch, sky_views};
use schemars::JsonSchema;
use serde::Serialize;

use super::format::{Format, outputs};
use super::json::SkyFile;
use super::{csv, study};
use crate::args::{Sky, SkyPatches};

/// The result of `sky`.
#[derive(Serialize, JsonSchema)]
pub(in crate::cmd) struct SkyFound {
    /// The files that were written.
    outputs: Vec<String>,
    /// Number of points.
    points: usize,
    /// Number of patches of the sky.
    patches: usize,
    /// Mean of the points' sky view factors, 0 to 1.
    mean_sky_view_factor: f64,
    /// Mean of the points' shade fractions, 0 to 1.
    mean_shade_fraction: f64,
    /// Wall time of tracing.
    trace_seconds: f64,
    /// Total wall time: loading, tracing and writing.
    seconds: f64,
}

pub(in crate::cmd) fn run(args: &Sky) -> Outcome {
    let start = Instant::now();
    let cancel = AtomicBool::new(false);
    let formats = outputs(&args.output, Format::OF_SKIES, &[&args.scene], &args.points)?;
    let patches = match args.patches {
        SkyPatches::Tregenza => Patches::tregenza(),
        SkyPatches::Reinhart => Patches::reinhart_577(),
    };
    with_threads(args.run.threads, || {
        let scene = study::load(&args.scene, &args.load, &args.run)?;
        let tracer = study::tracer(&scene, &args.load, &args.run)?;
        let receivers = study::points(&args.points, &tracer, args.load.ignore_alpha, &[&scene])?.receivers;
        args.run.memory_limit().check_peak("the points")?;
        let begun = Instant::now();
        let progress = study::reporter(args.progress);
        let views = sky_views(&tracer, &receivers, &patches, Watch::new(&progress, &cancel));
        let views = views.map_err(|error| study::failure(&error, "--patches"))?;
        let trace_seconds = begun.elapsed().as_secs_f64();
        args.run.memory_limit().check_peak("the skies of the points")?;
        let mut files = Outputs::default();
        for (path, format) in &formats {
            let bytes = match format {
                Format::Json => serde_json::to_vec(&SkyFile::new(&args.scene, &patches, &receivers, &views))
                    .map_err(|error| Failure::BadInput(format!("{}: {error}", path.display())))?,
                _ => csv::skies(&receivers, &views).into_bytes(),
            };
            files.add(path, &bytes)?;
        }
        files.place()?;
        let mean = |of: fn(&adumbra_sunlight::SkyView) -> f64| {
            views.iter().map(of).sum::<f64>() / views.len().max(1) as f64
        };
        let found = SkyFound {
            outputs: args.output.iter().map(|path| path.display().to_string()).collect(),
            points: receivers.len(),
            patches: patches.len(),
            mean_sky_view_factor: mean(|view| view.sky_view_factor),
            mean_shade_fraction: mean(|view| view.shade_fraction),
            trace_seconds,
            seconds: start.elapsed().as_secs_f64(),
        };
        if args.run.json {
            print_json(&found)?;
        } else {
            say!("{}: {} points, {} patches", args.scene.display(), found.points, found.patches);
            say!("  sky view factor  mean {:.4}", found.mean_sky_view_factor);
            say!("  shade fraction   mean {:.4}", found.mean_shade_fraction);
            say!("  traced in        {trace_seconds:.1} s");
            found.outputs.iter().for_each(|output| say!("  -> {output}"));
        }
        Ok(Code::Fine)
    })?
}
