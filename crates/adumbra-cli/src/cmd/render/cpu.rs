//! Pictures on the CPU: a file's shadows, rays, or where they differ.

use std::path::Path;

use adumbra::picture::{self, BaseColors, Shadows};
use adumbra::trace::{TraceOptions, Tracer};
use serde_json::json;

use super::Job;
use super::movers::numbered;
use crate::cmd::lookup::Asking;
use crate::exit::Failure;
use crate::output::write_png;

/// Every frame.
pub(super) fn draw(job: &Job<'_>, truth: bool, output: &Path) -> Result<(), Failure> {
    job.moments
        .iter()
        .try_for_each(|&(seconds, number)| draw_one(job, truth, seconds, &numbered(output, number)))
}

fn draw_one(job: &Job<'_>, truth: bool, seconds: f64, output: &Path) -> Result<(), Failure> {
    let args = job.args;
    let scene = job.scene_at(seconds);
    let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: job.ignore_alpha });
    let held = scene.memory_bytes() + tracer.memory_bytes() + BaseColors::bytes_of(&scene);
    args.work.check_memory("the scene, its rays' trees and its mip levels", held)?;
    let asking = Asking { bias: &args.bias, filter: args.filter, weights: args.weights.into() };
    let lookup = job.file.as_ref().map(|f| asking.lookup(f)).transpose()?;
    let shadows = match &lookup {
        Some(lookup) if args.diff => Shadows::Difference(&**lookup),
        Some(lookup) if !truth => Shadows::File(&**lookup),
        _ => Shadows::Truth,
    };
    let picture = picture::draw(&scene, &tracer, &job.camera, job.sun.towards(), &shadows, args.antialias);
    write_png(output, &picture)?;
    match picture.difference_share {
        Some(share) if !args.json => {
            say!("{}: file and rays differ on {:.3} % of the samples", output.display(), 100.0 * share);
        }
        share => {
            let figures = json!({ "device": "cpu", "difference_share": share });
            job.report(output, [picture.width, picture.height], figures);
        }
    }
    Ok(())
}
