//! Results of current engines at the truth cameras, next to ours: sun shadows here, ambient occlusion in
//! [`occlusion`].

pub mod occlusion;
mod sun;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use sun::{PeerFigures, PeerRow, SCENES, engines, figures, markdown};

use adumbra_html::page::Table;

/// The origin of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RowSource {
    /// Measured by this program, in this run.
    Here,
    /// Measured with another program, at the same cameras and against the same truth.
    MeasuredElsewhere,
}

impl RowSource {
    /// Returns the name in tables.
    fn word(self) -> &'static str {
        match self {
            Self::Here => "here",
            Self::MeasuredElsewhere => "elsewhere",
        }
    }
}

/// Returns a table as Markdown, with each row's name, its source and its cell for each scene.
fn table<'r, const N: usize>(
    subject: &str,
    scenes: [&str; N],
    rows: impl IntoIterator<Item = (&'r str, RowSource, [Option<String>; N])>,
) -> String {
    let mut table = Table::new("", &[&[subject, "measured"], &scenes[..]].concat());
    for (name, source, cells) in rows {
        let cells = cells.map(|cell| cell.unwrap_or_else(|| "–".to_owned()));
        table.row([name.to_owned(), source.word().to_owned()].into_iter().chain(cells));
    }
    table.markdown()
}

#[cfg(test)]
mod tests {
    use adumbra::Sun;
    use adumbra_scene::{Camera, Projection};

    use adumbra_compare::truth::TruthView;

    /// Returns a view of two by two lit pixels, of which the last one is sky.
    pub(super) fn four_pixels() -> TruthView {
        let projection = Projection::Perspective { fov_degrees: 45.0 };
        TruthView {
            camera: Camera { eye: [0.0; 3], target: [1.0; 3], projection, width: 2, height: 2 },
            sun: Sun::from_direction([0.0, 1.0, 0.0]).unwrap(),
            position: vec![[0.0; 3]; 4],
            normal: vec![[0.0, 1.0, 0.0]; 4],
            n_dot_l: vec![0.5; 4],
            visibility: vec![1.0; 4],
            ambient: vec![1.0; 4],
            ambient_radius_world: 1.0,
            valid: vec![true, true, true, false],
        }
    }
}
