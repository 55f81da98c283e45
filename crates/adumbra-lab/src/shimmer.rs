//! Shimmer: how a shadow factor at fixed world points changes while the camera moves.
//!
//! Definition: of the points followed from one frame to the next that lie near an edge of the true shadow, the share whose factor changes
//! by more than [`CHANGE`], and the mean size of the change over those points. Nothing in the world moves, so the right
//! figures are 0 and 0. Points off edges are counted too, apart: acne that comes and goes is found there.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// A smaller change of a factor is not seen.
pub const CHANGE: f32 = 0.05;

/// Changes over a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Shimmer {
    /// Points near edges, each counted once a pair of frames.
    pub edge_points: u64,
    /// Share of them that changed; none where there are none.
    pub edge_share: Option<f64>,
    /// Mean change of their factors, 0 to 1; none where there are none.
    pub edge_mean: Option<f64>,
    /// Points in all.
    pub points: u64,
    /// Share of all points that changed.
    pub share: f64,
}

/// Gathers changes pair by pair.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShimmerCount {
    edge_points: u64,
    edge_changed: u64,
    edge_sum: f64,
    points: u64,
    changed: u64,
}

impl ShimmerCount {
    /// Adds the factors `before` and `after` of the same points in two consecutive frames; `near_edge` says which lie near an edge.
    ///
    /// # Errors
    /// [`Error::Sizes`] where the three differ in length.
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

    /// The shares; none where no point was added.
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
    fn shimmer_of_nothing_is_nothing() {
        assert_eq!(ShimmerCount::default().finish(), None);
        let mut flat = ShimmerCount::default();
        flat.add(&[1.0], &[1.0], &[false]).unwrap();
        let s = flat.finish().unwrap();
        assert_eq!((s.edge_share, s.edge_mean, s.share), (None, None, 0.0));
        assert!(ShimmerCount::default().add(&[0.0], &[0.0], &[]).is_err());
    }
}
