//! Parts shared by the results of the benchmarks: requirements with their outcome, and numbers that JSON cannot hold.

use serde::{Deserialize, Deserializer, Serialize};

use crate::page::Table;

/// A requirement and its outcome.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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
    fn checks_are_a_table_of_markdown() {
        let check = |holds| Check { requirement: "a".to_owned(), measured: "b".to_owned(), holds };
        assert_eq!(
            Check::markdown(&[check(Some(true)), check(Some(false)), check(None)]),
            "| requirement | measured | |\n|---|---|---|\n| a | b | holds |\n| a | b | **does not hold** |\n| a | b | – |\n"
        );
    }
}
