//! Moves the origin of a mesh that is far from zero, as in cities in map coordinates. Single-precision floats
//! there have steps of half a metre, so the offset to the mesh is stored in its instance, which is double
//! precision.

use crate::affine::IDENTITY;

/// A mesh is far away along an axis if its distance from zero is more than this many times its longest side.
/// Below that distance, single-precision floats resolve a millionth of that side.
const FAR_SIDES: f64 = 16.0;

/// Bounding box of a mesh's positions as stated in the file.
pub(super) struct FarOrigin {
    low: [f64; 3],
    high: [f64; 3],
}

impl FarOrigin {
    /// The box of these positions, skipping those that overflow an `f32`. Cost: one pass.
    pub(super) fn of(positions: impl Iterator<Item = [f64; 3]>) -> Self {
        let mut found = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        for p in positions.filter(|p| p.iter().all(|&c| (c as f32).is_finite())) {
            found.low = std::array::from_fn(|a| found.low[a].min(p[a]));
            found.high = std::array::from_fn(|a| found.high[a].max(p[a]));
        }
        found
    }

    /// The offset to subtract from each coordinate: along axes on which the box is far away, the box side
    /// nearest to zero; 0 along the others.
    pub(super) fn offset(&self) -> [f64; 3] {
        let longest = (0..3).map(|a| self.high[a] - self.low[a]).fold(0.0, f64::max);
        std::array::from_fn(|a| {
            let nearest = self.low[a].max(0.0) + self.high[a].min(0.0);
            if nearest.abs() > FAR_SIDES * longest && nearest.is_finite() { nearest } else { 0.0 }
        })
    }
}

/// The transform of a mesh from whose positions `offset` was subtracted.
pub(super) fn placed_at(offset: [f64; 3]) -> [[f64; 4]; 3] {
    std::array::from_fn(|a| {
        let [x, y, z, _] = IDENTITY[a];
        [x, y, z, offset[a]]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_only_axes_that_are_far_from_zero() {
        let offset = |points: &[[f64; 3]]| FarOrigin::of(points.iter().copied()).offset();
        assert_eq!(
            offset(&[[500_000.25, 3.0, -5e6], [500_010.25, 9.0, -4_999_990.0]]),
            [500_000.25, 0.0, -4_999_990.0]
        );
        assert_eq!(offset(&[[100.0, 0.0, 0.0], [110.0, 0.0, 5.0]]), [0.0; 3]);
        // A single vertex that is invalid or far away does not offset the rest.
        assert_eq!(offset(&[[f64::NAN, 0.0, 0.0], [5e6, 1e300, 0.0]]), [0.0; 3]);
        assert_eq!(offset(&[[5e6, 0.0, 0.0], [0.0, 0.0, 0.0]]), [0.0; 3]);
        assert_eq!(offset(&[]), [0.0; 3]);
    }
}
