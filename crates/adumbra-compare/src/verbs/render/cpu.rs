//! Pictures drawn on the CPU: a file's shadows, traced shadows, or where they differ.

use std::path::Path;

use crate::Result;
use adumbra_program::output::write_png;
use adumbra_program::say;
use adumbra_truth::picture;
use adumbra_truth::picture::{BaseColors, Shadows};
use adumbra_truth::trace::{TraceOptions, Tracer};
use schemars::JsonSchema;
use serde::Serialize;

use super::movers::numbered;
use super::{Figures, Job};

/// Figures of a picture that was drawn on the CPU.
#[derive(Serialize, JsonSchema)]
pub(super) struct CpuFigures {
    /// On the CPU: share of the samples where file and rays differ. Null without `--diff`.
    difference_share: Option<f64>,
}

/// Draws every frame.
pub(super) fn draw(job: &Job<'_>, truth: bool, output: &Path) -> Result<()> {
    job.moments
        .iter()
        .try_for_each(|&(seconds, number)| draw_one(job, truth, seconds, &numbered(output, number)))
}

fn draw_one(job: &Job<'_>, truth: bool, seconds: f64, output: &Path) -> Result<()> {
    let args = job.args;
    let scene = job.scene_at(seconds);
    let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: job.ignore_alpha });
    let held = scene.memory_bytes() + tracer.memory_bytes() + BaseColors::bytes_of(&scene);
    args.run.check_memory("the scene, its acceleration structure and its mip levels", held, held)?;
    let lookup = job.files.lookup(&args.lookup)?;
    let shadows = match &lookup {
        Some(lookup) if args.diff => Shadows::Difference(&**lookup),
        Some(lookup) if !truth => Shadows::File(&**lookup),
        _ => Shadows::Truth,
    };
    let picture =
        picture::draw(&scene, &tracer, &job.camera, job.sun.sun.towards(), &shadows, args.antialias);
    write_png(output, &picture)?;
    match picture.difference_share {
        Some(share) if !args.run.json => {
            say!("{}: file and rays differ on {:.3} % of the samples", output.display(), 100.0 * share);
        }
        share => {
            let size = [picture.width, picture.height];
            job.report(output, size, "cpu".to_owned(), Figures::Cpu(CpuFigures { difference_share: share }));
        }
    }
    Ok(())
}
