//! What the colours of `--layer voxel-size` mean.

use adumbra_render::voxel::voxel_level_color;
use serde_json::{Value, json};

/// A level of a baked file that answers pixels.
struct Row {
    level: u32,
    /// Edge of its blocks.
    edge_world: f64,
    /// Of all pixels.
    share: f64,
}

/// The levels that are in a picture, fine to coarse.
pub(super) struct Legend(Vec<Row>);

impl Legend {
    /// Of levels by pixel, below 0 where nothing answers, and the edge of a voxel.
    pub(super) fn new(levels: &[f32], voxel_world: f64) -> Self {
        let row = |level: u32| {
            let pixels = levels.iter().filter(|l| **l == level as f32).count();
            let edge_world = voxel_world * f64::from(level).exp2();
            Row { level, edge_world, share: pixels as f64 / levels.len() as f64 }
        };
        let coarsest = levels.iter().copied().fold(-1.0, f32::max);
        let rows = (0..64).take_while(|level| *level as f32 <= coarsest).map(row);
        Self(rows.filter(|row| row.share > 0.0).collect())
    }

    /// A line a level.
    pub(super) fn print(&self) {
        for Row { level, edge_world, share } in &self.0 {
            say!("  level {level}: {edge_world:.4} m, {:.2} % of the pixels", 100.0 * share);
        }
    }

    /// For `--json`; colours are linear.
    pub(super) fn json(&self) -> Value {
        let row = |Row { level, edge_world, share }: &Row| {
            json!({
                "level": level,
                "edge_world": edge_world,
                "share": share,
                "color": voxel_level_color(*level),
            })
        };
        self.0.iter().map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legend_has_the_levels_that_are_there() {
        let Legend(rows) = Legend::new(&[-1.0, 0.0, 3.0, 3.0], 0.25);
        let found: Vec<_> = rows.iter().map(|r| (r.level, r.edge_world, r.share)).collect();
        assert_eq!(found, [(0, 0.25, 0.25), (3, 2.0, 0.5)]);
        assert!(Legend::new(&[-1.0; 4], 1.0).0.is_empty());
    }
}
