//! The legend of the colours of `--layer voxel-size`.

use adumbra_program::say;
use adumbra_render::voxel::voxel_level_color;
use schemars::JsonSchema;
use serde::Serialize;

/// A level of a baked file that answers pixels.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "VoxelLevel")]
pub(crate) struct Row {
    /// The level. 0 is the finest.
    level: u32,
    /// Edge of the level's blocks, world units.
    edge_world: f64,
    /// Share of the pixels that the level answers.
    share: f64,
    /// The level's colour in the picture: red, green and blue from 0 to 1, linear.
    color: [f32; 3],
}

/// The levels that occur in a picture, fine to coarse.
pub(super) struct Legend(Vec<Row>);

impl Legend {
    /// Builds the legend from the level of each pixel, which is below 0 if nothing answers, and the edge of a
    /// voxel.
    pub(super) fn new(levels: &[f32], voxel_world: f64) -> Self {
        let row = |level: u32| {
            let pixels = levels.iter().filter(|l| **l == level as f32).count();
            let edge_world = voxel_world * f64::from(level).exp2();
            let share = pixels as f64 / levels.len() as f64;
            Row { level, edge_world, share, color: voxel_level_color(level) }
        };
        let coarsest = levels.iter().copied().fold(-1.0, f32::max);
        let rows = (0..64).take_while(|level| *level as f32 <= coarsest).map(row);
        Self(rows.filter(|row| row.share > 0.0).collect())
    }

    /// Prints one line per level.
    pub(super) fn print(&self) {
        for Row { level, edge_world, share, .. } in &self.0 {
            say!("  level {level}: {edge_world:.4} world units, {:.2} % of the pixels", 100.0 * share);
        }
    }

    /// Returns the rows for `--json`.
    pub(super) fn rows(&self) -> Vec<Row> {
        self.0.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legend_lists_the_levels_in_the_picture() {
        let Legend(rows) = Legend::new(&[-1.0, 0.0, 3.0, 3.0], 0.25);
        let found: Vec<_> = rows.iter().map(|r| (r.level, r.edge_world, r.share)).collect();
        assert_eq!(found, [(0, 0.25, 0.25), (3, 2.0, 0.5)]);
        assert!(Legend::new(&[-1.0; 4], 1.0).0.is_empty());
    }
}
