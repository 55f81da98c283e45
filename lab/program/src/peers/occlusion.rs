//! Ambient occlusion: the errors of current engines at the truth cameras, and a table of ours next to theirs.
//!
//! The pictures have 320 × 240 pixels without anti-aliasing, alpha masks are ignored, and every valid pixel
//! counts. In rows that say "radius matched", the technique had the truth's radius in world units. The errors
//! are the RMSE of visibility and the mean of visibility minus truth; above 0 is too light.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{RowSource, table};
use crate::occlusion::occlusion_errors;
use adumbra_compare::error::Result;
use adumbra_compare::truth::TruthView;

/// The scenes, in the order of the columns. On alpine-2 the radius is a pixel on the screen, so that scene is
/// omitted.
pub const SCENES: [&str; 3] = ["kaykit_city_21", "box-city-5k", "zdm2"];

/// Both errors on one scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OcclusionFigures {
    /// Root-mean-square error of visibility.
    pub rmse: f64,
    /// Mean of visibility minus truth; `None` if it was not published.
    pub mean_signed: Option<f64>,
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OcclusionRow {
    /// Name of the technique or program.
    pub name: String,
    /// Origin of the figures.
    pub source: RowSource,
    /// Errors on each of [`SCENES`]; `None` if not measured.
    pub scenes: [Option<OcclusionFigures>; 3],
}

/// A row's name, and RMSE and mean signed error (if published) on each of [`SCENES`].
type Published = (&'static str, [(f64, Option<f64>); 3]);

const ELSEWHERE: [Published; 6] = [
    ("no ambient occlusion", [(0.327, None), (0.168, None), (0.156, None)]),
    (
        "Bevy SSAO High as shipped (0.73 m)",
        [(0.322, Some(0.232)), (0.166, Some(0.080)), (0.148, Some(0.053))],
    ),
    (
        "Bevy, radius matched, Ultra, raw visibility",
        [(0.165, Some(-0.029)), (0.156, Some(-0.089)), (0.157, Some(-0.121))],
    ),
    (
        "three.js GTAO, radius matched, 16 samples",
        [(0.214, Some(0.146)), (0.124, Some(0.060)), (0.115, Some(0.048))],
    ),
    (
        "three.js GTAO, radius matched, 64 samples",
        [(0.202, Some(0.137)), (0.123, Some(0.051)), (0.113, Some(0.047))],
    ),
    ("three.js SSAO, radius matched", [(0.209, Some(0.118)), (0.111, Some(0.011)), (0.099, Some(0.025))]),
];

fn row(source: RowSource, (name, figures): Published) -> OcclusionRow {
    let scenes = figures.map(|(rmse, mean_signed)| Some(OcclusionFigures { rmse, mean_signed }));
    OcclusionRow { name: name.to_owned(), source, scenes }
}

/// Returns the rows of the engines, after one without any occlusion.
pub fn engines() -> Vec<OcclusionRow> {
    ELSEWHERE.into_iter().map(|r| row(RowSource::MeasuredElsewhere, r)).collect()
}

/// Returns both errors of visibility that was drawn with the view's camera and radius, over the valid pixels.
///
/// # Errors
/// Returns [`adumbra_compare::Error::Sizes`] if the visibility does not have one value per pixel of the view.
pub fn figures(visibility: &[f32], view: &TruthView) -> Result<OcclusionFigures> {
    let errors = occlusion_errors(visibility, &view.ambient, |i| view.valid[i])?;
    Ok(OcclusionFigures { rmse: errors.rmse, mean_signed: Some(errors.mean_signed) })
}

/// Returns the table as Markdown.
pub fn markdown(rows: &[OcclusionRow]) -> String {
    let rows = rows.iter().map(|row| (&*row.name, row.source, row.scenes.map(|f| f.as_ref().map(cell))));
    table("ambient occlusion", SCENES, rows)
}

fn cell(figures: &OcclusionFigures) -> String {
    match figures.mean_signed {
        Some(signed) => format!("{:.3} ({signed:+.3})", figures.rmse),
        None => format!("{:.3}", figures.rmse),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::four_pixels;
    use super::*;

    #[test]
    fn occlusion_peers_table_lists_engines_and_own_rows() {
        let mut rows = engines();
        rows.push(OcclusionRow { name: "issao".to_owned(), source: RowSource::Here, scenes: [None; 3] });
        let text = markdown(&rows);
        assert_eq!(text.lines().count(), 2 + 6 + 1);
        assert!(text.contains("| no ambient occlusion | elsewhere | 0.327 | 0.168 | 0.156 |"));
        assert!(text.contains(
            "| three.js SSAO, radius matched | elsewhere | 0.209 (+0.118) | 0.111 (+0.011) | 0.099 (+0.025) |"
        ));
        assert!(text.contains("| issao | here | – | – | – |"));
    }

    #[test]
    fn occlusion_peers_figures_ignore_sky() {
        // Neither the sun's side nor its shadows count.
        let (n_dot_l, visibility, ambient) = (vec![-0.5; 4], vec![0.0; 4], vec![0.5, 0.5, 0.5, 1.0]);
        let view = TruthView { n_dot_l, visibility, ambient, ..four_pixels() };
        let f = figures(&[0.75, 0.25, 1.0, 0.0], &view).unwrap();
        assert!((f.rmse - 0.125_f64.sqrt()).abs() < 1e-12, "{f:?}");
        assert!((f.mean_signed.unwrap() - 0.5 / 3.0).abs() < 1e-12, "{f:?}");
        assert!(figures(&[0.0; 3], &view).is_err());
    }
}
