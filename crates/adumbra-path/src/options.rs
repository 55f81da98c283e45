//! Settings of a path's bake.

use adumbra_bake::BakeOptions;

/// Settings of a path's bake.
#[derive(Clone, Debug)]
pub struct PathOptions {
    /// Settings of each key's bake. Its sun, frame, size and levels are those of the path: the voxel size is
    /// that of a bake with the path's highest sun, and each key has one level.
    pub bake: BakeOptions,
    /// Share of points, in percent, that may be wrong half way between two keys in addition to those that are
    /// wrong in a file of that very sun; 0.1 unless set.
    pub error_percent: f64,
    /// Number of visible points that are compared; 20,000 unless set.
    pub points: usize,
    /// The least elevation of a key in degrees; 3 unless set. A lower sun is answered from the key nearest to
    /// it.
    pub lowest_degrees: f64,
    /// Whether keys are placed for [`PathSampler::quick`](adumbra::PathSampler::quick).
    pub quick: bool,
}

impl PathOptions {
    /// Returns the defaults, with these settings of each key's bake.
    pub fn new(bake: BakeOptions) -> Self {
        Self { bake, error_percent: 0.1, points: 20_000, lowest_degrees: 3.0, quick: false }
    }
}
