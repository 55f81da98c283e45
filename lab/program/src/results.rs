//! Parts shared by the results of the benchmarks: requirements with their outcome, how pictures are drawn and
//! timed, and numbers that JSON cannot represent.

use adumbra_render::Gpu;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use adumbra_html::page::Table;

/// A requirement and its outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Check {
    /// The quantity and its bound.
    pub(crate) requirement: String,
    /// The measured result, as text.
    pub(crate) measured: String,
    /// Whether the requirement holds; `None` if too little was measured.
    pub(crate) holds: Option<bool>,
}

impl Check {
    /// Returns the checks as a table, with the text `failed` in the last column of those that do not hold.
    pub(crate) fn table(checks: &[Self], caption: &str, failed: &str) -> Table {
        let mut table = Table::new(caption, &["requirement", "measured", ""]);
        for check in checks {
            let holds = check.holds.map_or("–", |holds| if holds { "holds" } else { failed });
            table.row([check.requirement.as_str(), check.measured.as_str(), holds]);
        }
        table
    }

    /// Returns the checks as Markdown.
    pub(crate) fn markdown(checks: &[Self]) -> String {
        Self::table(checks, "", "**does not hold**").markdown()
    }
}

/// How the pictures of a benchmark are drawn and timed.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Setup {
    /// Command that measured.
    pub(crate) command: String,
    /// Adapter that drew, with its driver.
    pub(crate) adapter: String,
    /// Whether the adapter is a software renderer.
    pub(crate) software: bool,
    /// Whether times are wall times, because the device has no timestamps or is a software renderer.
    pub(crate) wall_time: bool,
    /// Number of frames that each median is taken over.
    pub(crate) frames: u32,
    /// Width and height in pixels.
    pub(crate) size: [u32; 2],
}

impl Setup {
    /// Returns the setup of a command that has not opened a device yet.
    pub(crate) fn new(command: String, frames: u32, size: [u32; 2]) -> Self {
        Self { command, adapter: String::new(), software: false, wall_time: false, frames, size }
    }

    /// Records the device that draws.
    pub(crate) fn draw_on(&mut self, gpu: &Gpu) {
        self.adapter = gpu.name();
        self.software = gpu.is_software();
    }

    /// Returns the clock of the times, as the beginning of a sentence.
    pub(crate) fn clock(&self) -> &'static str {
        if self.software {
            "The adapter is a software renderer: times are wall times of its passes"
        } else if self.wall_time {
            "The device has no timestamps: times are wall times of its passes"
        } else {
            "Times are GPU timestamps"
        }
    }
}

/// Deserialises a number, with null as NaN: JSON has no number for values that are not finite.
pub(crate) fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Deserialises a pair of numbers, with null as NaN, like [`or_nan`].
pub(crate) fn pair_or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 2], D::Error> {
    let pair = <[Option<f64>; 2]>::deserialize(deserializer)?;
    Ok(pair.map(|number| number.unwrap_or(f64::NAN)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_render_as_markdown_table() {
        let check = |holds| Check { requirement: "a".to_owned(), measured: "b".to_owned(), holds };
        assert_eq!(
            Check::markdown(&[check(Some(true)), check(Some(false)), check(None)]),
            "| requirement | measured | |\n|---|---|---|\n| a | b | holds |\n| a | b | **does not hold** |\n| a | b | – |\n"
        );
    }
}
