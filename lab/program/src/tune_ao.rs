//! `adumbra-lab tune-ao`: runs the same parameter search for every ambient-occlusion estimator on the eight
//! scenes, and records the results.

use std::path::Path;
use std::time::Instant;

use adumbra_files::{TEXT_BYTES, read_whole};
use adumbra_program::exit::{Code, Failure};
use adumbra_program::output::write_whole;
use adumbra_program::say;
use adumbra_render::Gpu;
use adumbra_render::occlusion::{Estimator, OcclusionSettings};

use crate::args::TuneAo;
use crate::occlusion::{Record, TuneOptions, TuneScene, tune};
use adumbra_compare::Result;
use adumbra_compare::truth::Cache;

/// Tunes the estimators and writes record and table. With `--variant`, tunes the variants and prints their
/// results.
///
/// # Errors
///
/// Returns an error if a scene or the earlier record cannot be read, an output cannot be written, or the
/// device fails.
pub fn run(args: &TuneAo) -> Result<Code> {
    // Read first, so that an invalid record is reported before hours of work.
    let known = earlier(&args.record)?;
    let options = TuneOptions { budget: args.budget, ..TuneOptions::default() };
    let gpu = Gpu::request(&args.device.gpu_options())?;
    let cache = Cache::in_folder("target/truth-cache".into(), Cache::DEFAULT_LIMIT_BYTES);
    let begun = Instant::now();
    let scenes = TuneScene::all(&gpu, &args.scenes, &options, &cache)?;
    adumbra_program::note!("{} scenes ready after {:.0} s", scenes.len(), begun.elapsed().as_secs_f64());
    if !args.variant.is_empty() {
        return variants(args, &scenes, &options);
    }
    let estimators = if args.only.is_empty() { Estimator::ALL.to_vec() } else { args.only.clone() };
    let estimators: Vec<_> = estimators.into_iter().map(|e| OcclusionSettings::new(e, 1.0)).collect();
    let mut last = Instant::now();
    let found = tune(&scenes, &options, &estimators, |entry| {
        adumbra_program::note!(
            "{} on {}: {:.4}, elsewhere {:?}; {:.0} s",
            entry.estimator,
            entry.on.name(),
            entry.objective,
            entry.elsewhere,
            last.elapsed().as_secs_f64()
        );
        last = Instant::now();
    })?;
    let record = known.joined(found);
    let json = record.json().map_err(|e| Failure::BadInput(e.to_string()))?;
    write_whole(&args.record, json.as_bytes())?;
    write_whole(&args.table, record.markdown().as_bytes())?;
    say!("{}", args.table.display());
    Ok(Code::Fine)
}

/// Returns the record of an earlier run.
fn earlier(path: &Path) -> Result<Record> {
    let bytes = read_whole(path, TEXT_BYTES)?;
    let other = |e| Failure::BadInput(format!("{}: not a tuning record ({e})", path.display()));
    Ok(serde_json::from_slice(&bytes).map_err(other)?)
}

/// Tunes estimators with some of their parameters fixed, and prints the results.
fn variants(args: &TuneAo, scenes: &[TuneScene], options: &TuneOptions) -> Result<Code> {
    for spec in &args.variant {
        let settings = OcclusionSettings::from_spec(spec, 1.0)?;
        tune(scenes, options, &[settings], |entry| {
            let elsewhere = entry.elsewhere.map_or_else(String::new, |e| format!(", elsewhere {e:.4}"));
            say!("{spec} on {}: {:.4}{elsewhere}; {:?}", entry.on.name(), entry.objective, entry.settings);
        })?;
    }
    Ok(Code::Fine)
}
