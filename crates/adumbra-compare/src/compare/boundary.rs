//! How much finer a hybrid-resolution map is at the edges of the true shadow.
//!
//! A compared pixel is *at an edge* if it is within one coarsest texel, in the light's plane, of an edge in
//! the traced picture ([`super::near_edges`]). A look-up that ends `level` levels above the finest of
//! `merges` + 1 has texels 2^(`merges` - `level`) times finer than the coarsest. The gain is the mean of this
//! ratio over the pixels at edges, minus 1. A map with coarsest texels only has a gain of 0.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The gain of a hybrid-resolution map's levels at the edges of the true shadow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BoundaryGain {
    /// Number of pixels at edges.
    pub pixels: u64,
    /// Mean ratio of the coarsest texel size to the texel size, minus 1: 0 if all look-ups end at the
    /// coarsest level.
    pub gain: f64,
    /// Share of the pixels whose look-up ends at the finest level.
    pub at_finest: f64,
}

/// Returns the gain at `pixels` of a map of `merges` + 1 levels.
/// `levels` holds [`adumbra_render::Answer::Level`] of each pixel of the picture.
///
/// Pixels outside the map are skipped. If none remains, all values are zero.
pub fn boundary_gain(levels: &[f32], merges: u32, pixels: &[usize]) -> BoundaryGain {
    let ends = pixels.iter().filter_map(|&i| levels.get(i)).filter(|level| **level >= 0.0);
    let (mut count, mut finest, mut finer) = (0_u64, 0_u64, 0.0);
    for &level in ends {
        count += 1;
        finest += u64::from(level < 0.5);
        finer += (f64::from(merges) - f64::from(level)).exp2() - 1.0;
    }
    let whole = count.max(1) as f64;
    BoundaryGain { pixels: count, gain: finer / whole, at_finest: finest as f64 / whole }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boundary_gain_of_known_levels() {
        let levels = [0.0, 1.0, 2.0, 2.0, -1.0, 0.0];
        let g = boundary_gain(&levels, 2, &[0, 1, 2, 3, 4]);
        assert_eq!((g.pixels, g.at_finest), (4, 0.25));
        assert!((g.gain - (3.0 + 1.0) / 4.0).abs() < 1e-12);
        assert_eq!(boundary_gain(&levels, 2, &[2, 3]).gain, 0.0);
        assert_eq!(boundary_gain(&levels, 2, &[4]).pixels, 0);
    }
}
