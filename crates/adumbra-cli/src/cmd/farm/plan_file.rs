//! The file of a plan: where its scene is, how to load it, and the plan.

use std::fs;
use std::path::{Path, PathBuf};

use adumbra::IoError;
use adumbra_bake::BakePlan;
use adumbra_program::args::SceneArgs;
use adumbra_program::exit::Failure;
use serde::{Deserialize, Serialize};

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlanFile {
    pub(super) scene: PathBuf,
    pub(super) load: SceneArgs,
    pub(super) plan: BakePlan,
}

impl PlanFile {
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let text = fs::read(path).map_err(IoError::at("read", path))?;
        serde_json::from_slice(&text)
            .map_err(|error| Failure::BadInput(format!("{}: {error}", path.display())))
    }
}

/// Returns where the objects of a plan are, unless another place is given.
pub(super) fn cache_of(given: Option<&PathBuf>, plan: &Path) -> PathBuf {
    given.cloned().unwrap_or_else(|| plan.with_extension("cache"))
}
