//! Shimmer: changes of the shadow factor at fixed world-space points while the camera moves.
//!
//! It is measured on points near an edge of the true shadow, each followed from one frame to the next. The
//! results are the share of these points whose factor changes by more than [`CHANGE`], and their mean
//! absolute change. The world is static, so both should be 0. The share over all points is reported as well.
//! It includes acne that flickers where no edge is near.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Changes of a factor up to this are considered invisible.
pub const CHANGE: f32 = 0.05;

/// Shimmer along a camera path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Shimmer {
    /// Number of points near edges, each counted once per pair of frames.
    pub edge_points: u64,
    /// Share of the points near edges that changed; `None` without such points.
    pub edge_share: Option<f64>,
    /// Mean absolute change of the factors near edges, 0 to 1; `None` without such points.
    pub edge_mean: Option<f64>,
    /// Number of all points, each counted once per pair of frames.
    pub points: u64,
    /// Share of all points that changed.
    pub share: f64,
}

/// Accumulates changes over pairs of frames.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShimmerCount {
    edge_points: u64,
    edge_changed: u64,
    edge_sum: f64,
    points: u64,
    changed: u64,
}

impl ShimmerCount {
    /// Adds the factors `before` and `after` of the same points in two consecutive frames. `near_edge` says
    /// which of them are near an edge.
    ///
    /// # Errors
    /// Returns [`Error::Sizes`] if the three differ in length.
    pub fn add(&mut self, before: &[f32], after: &[f32], near_edge: &[bool]) -> Result<()> {
        Error::check_sizes("factors before and after", before.len(), after.len())?;
        Error::check_sizes("factors and edge marks", before.len(), near_edge.len())?;
        for ((before, after), &near) in before.iter().zip(after).zip(near_edge) {
            let change = (after - before).abs();
            let changed = u64::from(change > CHANGE);
            self.points += 1;
            self.changed += changed;
            if near {
                self.edge_points += 1;
                self.edge_changed += changed;
                self.edge_sum += f64::from(change);
            }
        }
        Ok(())
    }

    /// Returns the figures, or `None` if no point was added.
    pub fn finish(&self) -> Option<Shimmer> {
        let of = |part: f64, whole: u64| (whole > 0).then(|| part / whole as f64);
        (self.points > 0).then(|| Shimmer {
            edge_points: self.edge_points,
            edge_share: of(self.edge_changed as f64, self.edge_points),
            edge_mean: of(self.edge_sum, self.edge_points),
            points: self.points,
            share: self.changed as f64 / self.points as f64,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shimmer_counts_changes_near_edges_and_elsewhere() {
        let mut count = ShimmerCount::default();
        count.add(&[0.0, 0.5, 1.0, 0.0], &[0.0, 0.54, 0.5, 1.0], &[true, true, true, false]).unwrap();
        count.add(&[1.0], &[1.0], &[true]).unwrap();
        let s = count.finish().unwrap();
        assert_eq!((s.edge_points, s.points), (4, 5));
        let (share, mean) = (s.edge_share.unwrap(), s.edge_mean.unwrap());
        assert!((share - 0.25).abs() < 1e-12 && (s.share - 0.4).abs() < 1e-12);
        assert!((mean - 0.54 / 4.0).abs() < 1e-6);
    }

    #[test]
    fn shimmer_without_points_is_none() {
        assert_eq!(ShimmerCount::default().finish(), None);
        let mut flat = ShimmerCount::default();
        flat.add(&[1.0], &[1.0], &[false]).unwrap();
        let s = flat.finish().unwrap();
        assert_eq!((s.edge_share, s.edge_mean, s.share), (None, None, 0.0));
        assert!(ShimmerCount::default().add(&[0.0], &[0.0], &[]).is_err());
    }
}
