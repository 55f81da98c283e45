//! What a run of the fuzzer has looked at.

use std::fmt;

/// Why a receiver, or a tap of its filter, is promised nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Skip {
    /// It is the far side of a solid, or has no area.
    NoReceiver,
    /// Its slope is above 100; look-ups follow slopes of up to 120.
    Steep,
    /// The voxel lies outside the grid.
    OutsideGrid,
    /// Its triangle does not cover the texel's centre, where columns are sampled.
    NotCovered,
    /// The centre lies so near to an outline that snapping decides whether it is covered.
    Outline,
    /// A surface with holes lies over the centre; it is judged over the texel's area.
    Masked,
    /// The sampled point lies inside a solid.
    InsideSolid,
    /// Something lies between the surface and the point that its bias samples.
    WithinBias,
    /// Of taps only: fixed point moves the sampled point into the voxel before its own.
    Rounding,
}

impl Skip {
    /// All of them, in the order of their numbers.
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

/// Counts, of one scene or of many.
#[derive(Clone, Debug, Default)]
pub(super) struct Totals {
    pub(super) scenes: u64,
    /// Scenes that the bake refuses, or whose grid is too large to check.
    pub(super) refused: u64,
    pub(super) columns: u64,
    /// Columns that the fast builder drew.
    pub(super) drawn: u64,
    /// Receivers that were held against rays, and those of them that the rays call lit.
    pub(super) receivers: [u64; 2],
    /// How many taps of filters the look-ups answered, and how many of them are lit.
    pub(super) taps: [u64; 2],
    /// Filters that were held against the sum of their taps.
    pub(super) filters: u64,
    /// Receivers and taps that were not compared, by [`Skip`].
    pub(super) skipped: [u64; Skip::ALL.len()],
}

impl Totals {
    pub(super) fn skip(&mut self, reason: Skip) {
        self.skipped[reason as usize] += 1;
    }

    pub(super) fn add(&mut self, other: &Self) {
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
