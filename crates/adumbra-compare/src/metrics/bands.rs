//! Errors by distance from the camera, in bands whose bounds are 1, 2 and 5 times powers of ten.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FactorErrors, factor_errors};
use crate::error::Result;

/// Largest number of bands. If more are needed, the nearest ones are merged into the first.
const MAX_BANDS: usize = 8;

/// Errors of the pixels in a range of view depths.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Band {
    /// Lower bound of the view depth, in world units along the camera's forward direction.
    pub from_world: f64,
    /// Upper bound of the view depth in world units, exclusive.
    pub to_world: f64,
    /// Errors of the pixels in the band.
    pub errors: FactorErrors,
}

/// Returns the errors of the pixels for which `counts` holds, by view depth. The nearest band is first, and
/// no band is empty.
///
/// `depths` holds one view depth per pixel, in world units. Pixels whose depth is not finite and above 0 are
/// skipped.
///
/// # Errors
/// Returns [`crate::Error::Sizes`] if factors and truth differ in length.
pub fn bands(
    factors: &[f32],
    truth: &[f32],
    depths: &[f64],
    counts: impl Fn(usize) -> bool,
) -> Result<Vec<Band>> {
    let inside = || depths.iter().enumerate().filter(|(i, d)| counts(*i) && d.is_finite() && **d > 0.0);
    let (low, high) = inside().fold((f64::INFINITY, 0.0_f64), |(l, h), (_, &d)| (l.min(d), h.max(d)));
    if high == 0.0 {
        return Ok(Vec::new());
    }
    let ends = ends(low, high);
    let skipped = ends.len().saturating_sub(MAX_BANDS + 1);
    let mut found = Vec::new();
    for (number, pair) in ends.windows(2).enumerate().skip(skipped) {
        let from_world = if number == skipped && skipped > 0 { 0.0 } else { pair[0] };
        let to_world = pair[1];
        let within = |i: usize| counts(i) && (from_world..to_world).contains(&depths[i]);
        if let Some(errors) = factor_errors(factors, truth, within)? {
            found.push(Band { from_world, to_world, errors });
        }
    }
    Ok(found)
}

/// Returns the series 1, 2, 5, 10, …, from the last value at or below `low` to the first above `high`.
fn ends(low: f64, high: f64) -> Vec<f64> {
    let decade = libm::floor(libm::log10(low)) as i32;
    let mut ends = Vec::new();
    for power in decade.. {
        for step in [1.0, 2.0, 5.0] {
            let end = step * libm::pow(10.0, f64::from(power));
            if end <= low {
                ends.clear();
            }
            ends.push(end);
            if end > high {
                return ends;
            }
        }
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_enclose_the_depths() {
        assert_eq!(ends(3.0, 40.0), [2.0, 5.0, 10.0, 20.0, 50.0]);
        assert_eq!(ends(1.0, 1.5), [1.0, 2.0]);
        assert_eq!(ends(0.3, 0.4), [0.2, 0.5]);
    }

    #[test]
    fn bands_partition_the_pixels() {
        let depths = [1.0, 1.9, 2.0, 7.0, 9.0, f64::INFINITY];
        let truth = [1.0; 6];
        let factors = [1.0, 0.0, 1.0, 0.0, 1.0, 0.0];
        let found = bands(&factors, &truth, &depths, |i| i != 4).unwrap();
        let parts: Vec<_> =
            found.iter().map(|b| (b.from_world, b.errors.pixels, b.errors.wrong_shadowed)).collect();
        assert_eq!(parts, [(1.0, 2, 0.5), (2.0, 1, 0.0), (5.0, 1, 1.0)]);
    }

    #[test]
    fn surplus_bands_merge_into_the_first() {
        let depths: Vec<f64> = (0..14).map(|i| f64::from(1 << i) * 1.5).collect();
        let found = bands(&[1.0; 14], &[1.0; 14], &depths, |_| true).unwrap();
        assert!(found.len() <= MAX_BANDS && found[0].from_world == 0.0);
        assert_eq!(found.iter().map(|b| b.errors.pixels).sum::<u64>(), 14);
    }
}
