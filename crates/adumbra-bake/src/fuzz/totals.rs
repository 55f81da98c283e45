//! Counters of a fuzzer run.

use std::fmt;

/// The reason why nothing is guaranteed for a receiver, or for a tap of its filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Skip {
    /// The triangle is the far side of a solid, or has no area.
    NoReceiver,
    /// Its slope is above 100. Look-ups support slopes of up to 120.
    Steep,
    /// The voxel is outside the grid.
    OutsideGrid,
    /// The triangle does not cover the texel's centre, where columns are sampled.
    NotCovered,
    /// The centre is so near to an outline that snapping decides whether it is covered.
    Outline,
    /// A surface with holes covers the centre, which may be in a hole.
    Masked,
    /// The sampled point is inside a solid.
    InsideSolid,
    /// Something is between the surface and the point that its bias samples.
    WithinBias,
    /// For taps only: fixed-point rounding moves the sampled point into the voxel before its own.
    Rounding,
}

impl Skip {
    /// All reasons, in the order of their discriminants.
    const ALL: [Self; 9] = [
        Self::NoReceiver,
        Self::Steep,
        Self::OutsideGrid,
        Self::NotCovered,
        Self::Outline,
        Self::Masked,
        Self::InsideSolid,
        Self::WithinBias,
        Self::Rounding,
    ];
}

/// Counts for one scene or for many.
#[derive(Clone, Debug, Default)]
pub(crate) struct Totals {
    pub(crate) scenes: u64,
    /// Scenes that the bake refuses, or whose grid is too large to check.
    pub(crate) refused: u64,
    pub(crate) columns: u64,
    /// Columns that the fast builder drew.
    pub(crate) drawn: u64,
    /// Receivers that were compared with rays, and those among them that are lit according to the rays.
    pub(crate) receivers: [u64; 2],
    /// Filter taps that were compared with rays, and those among them that are lit.
    pub(crate) taps: [u64; 2],
    /// Filters that were compared with the sum of their taps.
    pub(crate) filters: u64,
    /// Receivers and taps that were not compared, by [`Skip`].
    pub(crate) skipped: [u64; Skip::ALL.len()],
}

impl Totals {
    pub(crate) fn skip(&mut self, reason: Skip) {
        self.skipped[reason as usize] += 1;
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.scenes += other.scenes;
        self.refused += other.refused;
        self.columns += other.columns;
        self.drawn += other.drawn;
        self.filters += other.filters;
        for n in 0..2 {
            self.receivers[n] += other.receivers[n];
            self.taps[n] += other.taps[n];
        }
        for (sum, n) in self.skipped.iter_mut().zip(other.skipped) {
            *sum += n;
        }
    }
}

impl fmt::Display for Totals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scenes, refused, columns, drawn, receivers, taps, filters, skipped } = self;
        write!(f, "{scenes} scenes, {refused} refused; {columns} columns, {drawn} drawn; ")?;
        write!(f, "{} receivers ({} lit), {} taps ({} lit), ", receivers[0], receivers[1], taps[0], taps[1])?;
        write!(f, "{filters} filters; skipped:")?;
        for reason in Skip::ALL {
            write!(f, " {reason:?} {}", skipped[reason as usize])?;
        }
        Ok(())
    }
}
