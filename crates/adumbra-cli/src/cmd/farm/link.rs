//! `adumbra link`: makes a plan's file from its entries.

use std::time::Instant;

use adumbra_bake::{BakeSummary, Watch};
use adumbra_files::{self as files, StagedFile};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::memory::Guard;
use adumbra_program::output::{SCENE, format_bytes, print_json, refuse_inputs, refuse_read};
use adumbra_program::threads::with_threads;
use adumbra_program::{memory, say};
use schemars::JsonSchema;
use serde::Serialize;

use super::plan_file::{PlanFile, cache_of};
use crate::args::Link;
use crate::cmd::store::open_or_create;

/// What is printed with `--json`.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Linked {
    /// The shadow file that was written.
    file: String,
    /// Wall time.
    seconds: f64,
    /// Length of the shadow file, in bytes.
    file_bytes: u64,
    /// Number of levels of detail.
    levels: u32,
    /// The largest resident size of the process. If the system does not report it, the bytes that were
    /// counted.
    peak_bytes: u64,
    /// Bytes that were written to disk because of `--max-memory`.
    spilled_bytes: u64,
}

pub(crate) fn run(args: &Link) -> Outcome {
    let start = Instant::now();
    let bad_input = |e: Failure| Failure::BadInput(e.to_string());
    let place = cache_of(args.cache.as_ref(), &args.plan);
    let PlanFile { plan, scene, load } = PlanFile::read(&args.plan)?;
    let inputs = [("the plan", &*args.plan), ("the cache", &*place), (SCENE, &*scene)];
    let edits = load.edit().map(|path| ("the edits", &**path));
    refuse_inputs("--output", &args.output, inputs.into_iter().chain(edits)).map_err(bad_input)?;
    files::check_output(&args.output)?;
    refuse_read("--output", &args.output).map_err(bad_input)?;
    with_threads(args.run.threads, || {
        let limit = args.run.memory_limit();
        let share = limit.share(0);
        let cache = open_or_create(&place)?;
        let output = &args.output;
        let limits = plan.options().with(|o| o.max_memory_bytes = share.bytes());
        let guard = Guard::new(limit);
        let progress = |_| guard.look();
        let linked = plan.stage_link(&cache, &limits, Watch::new(&progress, guard.cancel()), output);
        let (staged, written) = guard.end("linking", &share, linked)?;
        StagedFile::place([staged])?;
        let BakeSummary { levels, bytes: file_bytes, report, .. } = written;
        let seconds = start.elapsed().as_secs_f64();
        let peak_bytes = memory::peak_bytes().unwrap_or(report.accounted_bytes);
        if args.run.json {
            print_json(&Linked {
                file: output.display().to_string(),
                seconds,
                file_bytes,
                levels,
                peak_bytes,
                spilled_bytes: report.spilled_bytes,
            })?;
        } else {
            let (plan, file, peak) = (args.plan.display(), output.display(), format_bytes(peak_bytes));
            say!("{plan} -> {file} ({}) in {seconds:.1} s, peak memory {peak}", format_bytes(file_bytes));
        }
        Ok(Code::Fine)
    })?
}
