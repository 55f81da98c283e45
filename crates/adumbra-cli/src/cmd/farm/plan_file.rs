//! The file of a plan: where its scene is, how to load it, and the plan.

use std::path::{Path, PathBuf};

use adumbra_bake::BakePlan;
use adumbra_files::read_whole;
use adumbra_program::args::SceneArgs;
use adumbra_program::exit::Failure;
use serde::{Deserialize, Serialize};

/// Most bytes of a plan: a part takes about a hundred, and a plan has a million at most.
const PLAN_BYTES: u64 = 1 << 30;

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlanFile {
    pub(super) scene: PathBuf,
    pub(super) load: SceneArgs,
    pub(super) plan: BakePlan,
}

impl PlanFile {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let text = read_whole(path, PLAN_BYTES)?;
        serde_json::from_slice(&text)
            .map_err(|error| Failure::BadInput(format!("{}: {error}", path.display())))
    }
}

/// Returns the place of a plan's entries: the given one, or a folder beside the plan.
pub(super) fn cache_of(given: Option<&PathBuf>, plan: &Path) -> PathBuf {
    given.cloned().unwrap_or_else(|| plan.with_extension("cache"))
}
