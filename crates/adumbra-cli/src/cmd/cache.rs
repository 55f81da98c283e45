//! `adumbra cache`: inspects or prunes the cache of `bake --cache`.

use std::path::Path;

use adumbra::IoError;
use adumbra_bake::CacheReport;
use adumbra_program::exit::{Code, Outcome};
use adumbra_program::output::{format_bytes, print_json};
use adumbra_program::say;
use schemars::JsonSchema;
use serde::Serialize;

use super::store::Store;
use crate::args::{Cache, CacheInfo, CachePrune};

/// The contents of a bake cache.
#[derive(Serialize, JsonSchema)]
pub(super) struct CacheContents {
    /// Number of entries.
    entries: u64,
    /// Their bytes.
    bytes: u64,
    /// Number of temporary files that programs left more than a day ago because they were killed.
    abandoned: u64,
    /// Their bytes.
    abandoned_bytes: u64,
}

impl From<&CacheReport> for CacheContents {
    fn from(report: &CacheReport) -> Self {
        let &CacheReport { entries, bytes, abandoned, abandoned_bytes, .. } = report;
        Self { entries, bytes, abandoned, abandoned_bytes }
    }
}

/// What was removed from a bake cache, and what is left.
#[derive(Serialize, JsonSchema)]
pub(super) struct Pruned {
    /// What was removed.
    removed: CacheContents,
    /// What is left.
    left: CacheContents,
}

pub(crate) fn run(args: &Cache) -> Outcome {
    match args {
        Cache::Info(args) => info(args),
        Cache::Prune(args) => prune(args),
    }
}

fn info(args: &CacheInfo) -> Outcome {
    let found = Store::open(&args.place)?.contents()?;
    warn(&args.place, &found.failures, "");
    if args.json {
        print_json(&CacheContents::from(&found))?;
    } else {
        say!("{}: {}", args.place.display(), said(&found));
    }
    Ok(Code::Fine)
}

fn prune(args: &CachePrune) -> Outcome {
    let store = Store::open(&args.place)?;
    let removed = store.prune(args.keep)?;
    warn(&args.place, &removed.failures, "; it stays");
    let left = store.contents()?;
    if args.json {
        print_json(&Pruned { removed: (&removed).into(), left: (&left).into() })?;
    } else {
        say!("{}: removed {}; left {}", args.place.display(), said(&removed), said(&left));
    }
    if left.bytes > args.keep && !removed.failures.is_empty() {
        adumbra_program::note!("error: {}: more than --keep is left", args.place.display());
        return Ok(Code::BadInput);
    }
    Ok(Code::Fine)
}

fn said(report: &CacheReport) -> String {
    let entries = format!("{} entries, {}", report.entries, format_bytes(report.bytes));
    if report.abandoned == 0 {
        return entries;
    }
    format!(
        "{entries}, and {} temporary files of killed programs, {}",
        report.abandoned,
        format_bytes(report.abandoned_bytes)
    )
}

fn warn(place: &Path, failures: &[IoError], consequence: &str) {
    for failure in failures {
        adumbra_program::note!("warning: {}: {failure}{consequence}", place.display());
    }
}
