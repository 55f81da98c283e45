//! Filters of light-aligned files and their limits.

use std::ops::RangeInclusive;

use adumbra::{Layout, RangeError};
use adumbra_shaders::constants::DEPTHS_MAX_RADIUS;

/// The filter of a light-aligned file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VoxelFilter {
    /// The mean over K × K texels, with K one of [`adumbra::query::FILTER_WIDTHS`].
    Taps(u32),
    /// Penumbrae of a sun. Only for files in the layout `depths`.
    Soft {
        /// Full angle of the sun, degrees, 0.01 to 20.
        angle_degrees: f64,
        /// Largest radius of a penumbra, texels, 1 to 64.
        max_radius_texels: f64,
    },
}

pub(super) const ANGLES_DEGREES: RangeInclusive<f64> = 0.01..=20.0;
pub(super) const RADII_TEXELS: RangeInclusive<f64> = 1.0..=DEPTHS_MAX_RADIUS as f64;

impl VoxelFilter {
    /// Checks that penumbrae have the right layout, and that their sun and reach are within the shader's limits. Filter
    /// widths are checked by the look-up.
    pub(super) fn check(self, layout: Layout) -> std::result::Result<(), RangeError> {
        let Self::Soft { angle_degrees, max_radius_texels } = self else { return Ok(()) };
        if layout != Layout::Depths {
            return Err(RangeError::new("the layout", layout.name(), "depths, for penumbrae"));
        }
        for (name, value, range, text) in [
            ("the sun's angle", angle_degrees, ANGLES_DEGREES, "from 0.01 to 20 degrees"),
            ("the largest radius", max_radius_texels, RADII_TEXELS, "from 1 to 64 texels"),
        ] {
            if !range.contains(&value) {
                return Err(RangeError::new(name, value, text));
            }
        }
        Ok(())
    }
}
