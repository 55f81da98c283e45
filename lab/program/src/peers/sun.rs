//! Sun shadows: the two errors of current engines at the truth cameras, and a table of ours next to theirs.
//!
//! The pictures have 320 × 240 pixels without anti-aliasing, alpha masks are ignored, and valid pixels with
//! n·l > 0.1 count. The first error is the share of pixels on the wrong side of 1/2, the second the mean
//! |shadow factor - truth|, both in %. Quote both: the first does not show acne at half strength.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{RowSource, table};
use adumbra_compare::error::Result;
use adumbra_compare::metrics::factor_errors;
use adumbra_compare::truth::TruthView;

/// The scenes, in the order of the columns.
pub const SCENES: [&str; 4] = ["kaykit_city_21", "box-city-5k", "zdm2", "alpine-2"];
/// Pixels count if the cosine between normal and sun is above this.
const MIN_N_DOT_L: f32 = 0.1;

/// Both errors on one scene, in %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeerFigures {
    /// Share of pixels on the wrong side of 1/2, 0 to 100.
    pub wrong_percent: f64,
    /// Mean |shadow factor - truth|, 0 to 100.
    pub mean_percent: f64,
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PeerRow {
    /// Name of the technique or program.
    pub name: String,
    /// Origin of the figures.
    pub source: RowSource,
    /// Errors on each of [`SCENES`]; `None` if not measured.
    pub scenes: [Option<PeerFigures>; 4],
}

const ELSEWHERE: [(&str, [(f64, f64); 4]); 8] = [
    ("Bevy 0.19.1, default cascades (150 m)", [(9.42, 9.7), (18.51, 18.7), (1.34, 1.6), (9.98, 10.0)]),
    ("Bevy 0.19.1, distance = scene, 4 × 2048²", [(6.47, 7.0), (1.59, 2.7), (1.30, 1.5), (6.51, 8.5)]),
    ("Bevy 0.19.1, distance = scene, 4 × 4096²", [(3.48, 4.3), (0.69, 1.4), (0.64, 0.8), (3.26, 5.2)]),
    (
        "Bevy 0.19.1, cascades fitted to this one view, 4 × 4096²",
        [(2.58, 3.3), (0.42, 0.9), (0.59, 0.7), (2.79, 4.5)],
    ),
    (
        "Bevy 0.19.1 with adumbra: a file of 16,384, filter 1",
        [(0.42, 0.4), (0.22, 0.2), (0.04, 0.0), (0.17, 0.2)],
    ),
    (
        "three.js r187, CSM 4 × 4096², single-sided default",
        [(0.77, 1.5), (0.29, 0.5), (0.16, 0.3), (9.66, 10.2)],
    ),
    (
        "three.js r187, SunLight 4096², biases of a texel",
        [(2.36, 2.8), (0.52, 0.7), (0.52, 0.6), (11.04, 10.6)],
    ),
    (
        "three.js r187 with adumbra: a file of 16,384, filter 1",
        [(0.40, 0.40), (0.23, 0.23), (0.05, 0.05), (0.21, 0.21)],
    ),
];

fn row(source: RowSource, (name, figures): (&str, [(f64, f64); 4])) -> PeerRow {
    let scenes =
        figures.map(|(wrong_percent, mean_percent)| Some(PeerFigures { wrong_percent, mean_percent }));
    PeerRow { name: name.to_owned(), source, scenes }
}

/// Returns the rows of the engines.
pub fn engines() -> Vec<PeerRow> {
    ELSEWHERE.into_iter().map(|r| row(RowSource::MeasuredElsewhere, r)).collect()
}

/// Returns both errors of shadow factors that were drawn with the view's camera, or `None` if no valid pixel
/// has n·l > 0.1.
///
/// # Errors
/// Returns [`adumbra_compare::Error::Sizes`] if there is not one factor per pixel of the view.
pub fn figures(factors: &[f32], view: &TruthView) -> Result<Option<PeerFigures>> {
    let judged = |i: usize| view.valid[i] && view.n_dot_l[i] > MIN_N_DOT_L;
    let errors = factor_errors(factors, &view.visibility, judged)?;
    Ok(errors
        .map(|e| PeerFigures { wrong_percent: 100.0 * e.wrong(), mean_percent: 100.0 * e.mean_difference }))
}

/// Returns the table as Markdown.
pub fn markdown(rows: &[PeerRow]) -> String {
    let cell = |f: PeerFigures| format!("{:.2} ({:.1})", f.wrong_percent, f.mean_percent);
    let rows = rows.iter().map(|row| (&*row.name, row.source, row.scenes.map(|f| f.map(cell))));
    table("sun shadow", SCENES, rows)
}

#[cfg(test)]
mod tests {
    use super::super::tests::four_pixels;
    use super::*;

    #[test]
    fn sun_peers_table_lists_engines_and_own_rows() {
        let mut rows = engines();
        rows.push(PeerRow { name: "voxel".to_owned(), source: RowSource::Here, scenes: [None; 4] });
        let text = markdown(&rows);
        assert_eq!(text.lines().count(), 2 + 8 + 1);
        assert!(
            text.contains("| three.js r187, CSM 4 × 4096², single-sided default | elsewhere | 0.77 (1.5) |")
        );
        assert!(text.contains("| voxel | here | – | – | – | – |"));
    }

    #[test]
    fn sun_peers_figures_ignore_invalid_and_grazing_pixels() {
        let (n_dot_l, visibility) = (vec![0.5, 0.5, 0.1, 0.5], vec![1.0, 0.0, 1.0, 1.0]);
        let view = TruthView { n_dot_l, visibility, ..four_pixels() };
        let f = figures(&[0.25, 0.25, 0.0, 0.0], &view).unwrap().unwrap();
        assert_eq!((f.wrong_percent, f.mean_percent), (50.0, 50.0));
        assert!(figures(&[0.0; 3], &view).is_err());
    }
}
