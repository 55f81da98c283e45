//! `report.json`: what was run, how it went, and all figures.

use std::io::ErrorKind;
use std::path::Path;

use adumbra::Error;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::machine::Machine;
use crate::exit::Failure;
use crate::output::write_whole;

/// The file's name.
const NAME: &str = "report.json";

/// The whole file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Record {
    /// Of the last run. What it did not measure keeps its own.
    pub(super) machine: Machine,
    pub(super) sections: Vec<SectionRecord>,
}

/// One section.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct SectionRecord {
    /// As `--only` calls it.
    pub(super) section: String,
    /// Full sizes, or the quick run's.
    pub(super) full: bool,
    /// What it was measured on, and when.
    pub(super) machine: Machine,
    pub(super) outcome: Outcome,
    pub(super) steps: Vec<StepRecord>,
    /// What its commands wrote as JSON, by path.
    pub(super) figures: Map<String, Value>,
}

/// One command.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct StepRecord {
    /// What the page calls it.
    pub(super) name: String,
    /// To be typed in the report's folder.
    pub(super) command: String,
    pub(super) seconds: f64,
    /// What it said when it failed.
    pub(super) error: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Outcome {
    Measured,
    /// Measured, and something does not hold.
    CheckFailed,
    Failed,
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
    /// One of which nothing is measured yet: as it stands where the run is cut off.
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
    /// What an earlier run left in `folder`; an error where a file of that name is something else.
    pub(super) fn earlier(folder: &Path) -> Result<Option<Self>, Failure> {
        let path = folder.join(NAME);
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(Error::io("read", &path)(e).into()),
        };
        serde_json::from_slice(&bytes).map(Some).map_err(|e| {
            Failure::BadInput(format!(
                "{}: not what an earlier report wrote ({e}); remove it",
                path.display()
            ))
        })
    }

    pub(super) fn write(&self, folder: &Path) -> Result<(), Failure> {
        write_whole(&folder.join(NAME), format!("{:#}\n", self.value()?).as_bytes())
    }

    pub(super) fn value(&self) -> Result<Value, Failure> {
        serde_json::to_value(self).map_err(|e| Failure::BadInput(e.to_string()))
    }

    pub(super) fn section(&self, name: &str) -> Option<&SectionRecord> {
        self.sections.iter().find(|s| s.section == name)
    }

    /// What a section was measured on where that is not what the header names.
    pub(super) fn elsewhere(&self, name: &str) -> Option<String> {
        self.section(name).and_then(|s| s.machine.unlike(&self.machine))
    }

    /// Puts a section in place of an earlier one of its name, or behind all, in the order of `names`.
    pub(super) fn put(&mut self, section: SectionRecord, names: &[&str]) {
        self.sections.retain(|s| s.section != section.section);
        self.sections.push(section);
        let place = |s: &SectionRecord| names.iter().position(|n| *n == s.section);
        self.sections.sort_by_key(place);
    }
}
