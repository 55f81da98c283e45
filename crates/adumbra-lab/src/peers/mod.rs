//! What today's engines get on the truth cameras, beside ours: sun shadows here, ambient occlusion in [`occlusion`].

pub mod occlusion;
mod sun;

use serde::{Deserialize, Serialize};
pub use sun::{PeerFigures, PeerRow, SCENES, aim, engines, figures, markdown};

/// Where a row comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RowSource {
    /// By this program, in this run.
    Here,
    /// On the same cameras against the same truth, with another program.
    MeasuredElsewhere,
    /// What is aimed at.
    Aim,
}

impl RowSource {
    /// As tables call it.
    fn word(self) -> &'static str {
        match self {
            Self::Here => "here",
            Self::MeasuredElsewhere => "elsewhere",
            Self::Aim => "–",
        }
    }
}
