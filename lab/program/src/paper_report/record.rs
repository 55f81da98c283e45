//! `report.json`: the commands that were run, their outcome, and all results.

use std::io::ErrorKind;
use std::path::Path;

use adumbra_files::{TEXT_BYTES, read_whole};
use adumbra_program::exit::Failure;
use adumbra_program::output::write_whole;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::machine::Machine;
use adumbra_compare::Result;

/// The file's name.
const NAME: &str = "report.json";

/// The whole file.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Record {
    /// Machine of the last run. Sections that it did not measure keep their own.
    pub(super) machine: Machine,
    /// The sections.
    pub(super) sections: Vec<SectionRecord>,
}

/// One section.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(super) struct SectionRecord {
    /// Name for `--only`.
    pub(super) section: String,
    /// Whether it was measured at full sizes rather than those of a quick run.
    pub(super) full: bool,
    /// Machine and date of the measurement.
    pub(super) machine: Machine,
    /// What came of it.
    pub(super) outcome: Outcome,
    /// Its commands.
    pub(super) steps: Vec<StepRecord>,
    /// JSON files that its commands wrote, by path.
    pub(super) figures: Map<String, Value>,
}

/// One command.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(super) struct StepRecord {
    /// Name on the page.
    pub(super) name: String,
    /// Command line to run in the report's folder.
    pub(super) command: String,
    /// Wall time in seconds.
    pub(super) seconds: f64,
    /// Error message if it failed.
    pub(super) error: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum Outcome {
    /// Measured; every requirement holds.
    Measured,
    /// Measured, but a requirement does not hold.
    CheckFailed,
    /// A command failed.
    Failed,
    /// The run was interrupted.
    Interrupted,
}

impl Outcome {
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Measured => "measured",
            Self::CheckFailed => "measured; a check failed",
            Self::Failed => "failed",
            Self::Interrupted => "interrupted",
        }
    }
}

impl SectionRecord {
    /// Returns a section without measurements. It remains in the record if the run is cut off.
    pub(super) fn begun(section: &str, full: bool, machine: &Machine) -> Self {
        Self {
            section: section.to_owned(),
            full,
            machine: machine.clone(),
            outcome: Outcome::Interrupted,
            steps: Vec::new(),
            figures: Map::new(),
        }
    }

    pub(super) fn seconds(&self) -> f64 {
        self.steps.iter().map(|s| s.seconds).sum()
    }
}

impl Record {
    /// Reads the record of an earlier run in `folder`, or returns `None` if there is none.
    ///
    /// # Errors
    /// Returns an error if a file of that name is not a record.
    pub(super) fn earlier(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join(NAME);
        let bytes = match read_whole(&path, TEXT_BYTES) {
            Ok(bytes) => bytes,
            Err(e) if e.source.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(e.into()),
        };
        let other = |e| {
            Failure::BadInput(format!(
                "{}: not the record of an earlier report ({e}); remove it, or give another --output",
                path.display()
            ))
        };
        Ok(serde_json::from_slice(&bytes).map(Some).map_err(other)?)
    }

    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        Ok(write_whole(&folder.join(NAME), format!("{:#}\n", self.value()?).as_bytes())?)
    }

    pub(super) fn value(&self) -> Result<Value> {
        Ok(serde_json::to_value(self).map_err(|e| Failure::BadInput(e.to_string()))?)
    }

    pub(super) fn section(&self, name: &str) -> Option<&SectionRecord> {
        self.sections.iter().find(|s| s.section == name)
    }

    /// Describes the machine of a section if it differs from that of the last run.
    pub(super) fn elsewhere(&self, name: &str) -> Option<String> {
        self.section(name).and_then(|s| s.machine.unlike(&self.machine))
    }

    /// Adds a section or replaces the earlier one of its name, then sorts the sections in the order of
    /// `names`.
    pub(super) fn put(&mut self, section: SectionRecord, names: &[&str]) {
        self.sections.retain(|s| s.section != section.section);
        self.sections.push(section);
        let place = |s: &SectionRecord| names.iter().position(|n| *n == s.section);
        self.sections.sort_by_key(place);
    }
}
