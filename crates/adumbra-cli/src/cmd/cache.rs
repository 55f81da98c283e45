//! `adumbra cache`: looks after what `bake --cache` keeps.

use adumbra_bake::FolderContents;
use adumbra_program::exit::{Code, Outcome};
use adumbra_program::output::{format_bytes, print_json};
use adumbra_program::say;
use schemars::JsonSchema;
use serde::Serialize;

use super::store::Store;
use crate::args::{Cache, CacheInfo, CachePrune};

/// What a folder or store of objects has.
#[derive(Serialize, JsonSchema)]
pub(super) struct CacheContents {
    /// Number of objects.
    objects: u64,
    /// Their bytes.
    bytes: u64,
}

impl From<FolderContents> for CacheContents {
    fn from(FolderContents { objects, bytes }: FolderContents) -> Self {
        Self { objects, bytes }
    }
}

/// What was removed from a folder or store of objects, and what is left.
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
    let contents = Store::open(&args.place)?.contents()?;
    if args.json {
        print_json(&CacheContents::from(contents))?;
    } else {
        say!("{}: {} objects, {}", args.place.display(), contents.objects, format_bytes(contents.bytes));
    }
    Ok(Code::Fine)
}

fn prune(args: &CachePrune) -> Outcome {
    let store = Store::open(&args.place)?;
    let removed = store.prune(args.keep)?;
    let left = store.contents()?;
    if args.json {
        print_json(&Pruned { removed: removed.into(), left: left.into() })?;
    } else {
        let said = |FolderContents { objects, bytes }| format!("{objects} objects, {}", format_bytes(bytes));
        say!("{}: removed {}; left {}", args.place.display(), said(removed), said(left));
    }
    Ok(Code::Fine)
}
