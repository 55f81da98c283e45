//! Results of current engines at the truth cameras, next to ours: sun shadows here, ambient occlusion in [`occlusion`].

pub mod occlusion;
mod sun;

use serde::{Deserialize, Serialize};
pub use sun::{PeerFigures, PeerRow, SCENES, aim, engines, figures, markdown};

/// The origin of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum RowSource {
    /// Measured by this program, in this run.
    Here,
    /// Measured with another program, at the same cameras and against the same truth.
    MeasuredElsewhere,
    /// A target, not a measurement.
    Aim,
}

impl RowSource {
    /// Returns the name in tables.
    fn word(self) -> &'static str {
        match self {
            Self::Here => "here",
            Self::MeasuredElsewhere => "elsewhere",
            Self::Aim => "–",
        }
    }
}
