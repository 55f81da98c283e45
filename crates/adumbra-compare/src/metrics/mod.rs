//! Metrics of the error of shadows with respect to the truth.
//!
//! RMSE and the shares of wrong pixels are of shadow factors, [`ssim()`] and [`flip()`] of composited sRGB
//! pictures. A factor above 1/2 is lit, in the result as in the truth.

mod bands;
pub mod flip;
mod ssim;

pub use bands::{Band, bands};
pub use flip::flip;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
pub use ssim::ssim;

use crate::error::{Error, Result};

/// Errors of shadow factors over a set of pixels. Shares are of those pixels, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FactorErrors {
    /// Number of pixels compared.
    pub pixels: u64,
    /// Root-mean-square error, 0 to 1.
    pub rmse: f64,
    /// Mean absolute difference, 0 to 1.
    pub mean_difference: f64,
    /// Share of pixels that are shadowed in the truth but lit in the result, 0 to 1: light leaks.
    pub wrong_lit: f64,
    /// Share of pixels that are lit in the truth but shadowed in the result, 0 to 1: acne.
    pub wrong_shadowed: f64,
}

impl FactorErrors {
    /// Returns the share of pixels on the wrong side of 1/2.
    pub fn wrong(&self) -> f64 {
        self.wrong_lit + self.wrong_shadowed
    }
}

/// Whether a factor counts as lit.
pub fn is_lit(factor: f32) -> bool {
    factor > 0.5
}

/// Compares `factors` with `truth`, one of each per pixel, over the pixels for whose index
/// `counts` holds. Returns `None` if there is no such pixel.
///
/// # Errors
/// Returns [`Error::Sizes`] if the two differ in length.
pub fn factor_errors(
    factors: &[f32],
    truth: &[f32],
    counts: impl Fn(usize) -> bool,
) -> Result<Option<FactorErrors>> {
    Error::check_sizes("shadow factors and truth", factors.len(), truth.len())?;
    let (mut squares, mut sizes, mut pixels, mut lit, mut shadowed) = (0.0, 0.0, 0_u64, 0_u64, 0_u64);
    for (index, (&answer, &right)) in factors.iter().zip(truth).enumerate() {
        if !counts(index) {
            continue;
        }
        let difference = f64::from(answer) - f64::from(right);
        pixels += 1;
        squares += difference * difference;
        sizes += difference.abs();
        lit += u64::from(is_lit(answer) && !is_lit(right));
        shadowed += u64::from(!is_lit(answer) && is_lit(right));
    }
    let whole = pixels as f64;
    Ok((pixels > 0).then(|| FactorErrors {
        pixels,
        rmse: (squares / whole).sqrt(),
        mean_difference: sizes / whole,
        wrong_lit: lit as f64 / whole,
        wrong_shadowed: shadowed as f64 / whole,
    }))
}

/// Returns the median, or the upper of the two middle values if their number is even. NaN if there are no
/// values.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factor_errors_of_known_values() {
        let truth = [0.0, 0.0, 1.0, 1.0, 0.75];
        let answer = [0.0, 1.0, 0.0, 1.0, 0.25];
        let e = factor_errors(&answer, &truth, |_| true).unwrap().unwrap();
        assert_eq!(e.pixels, 5);
        assert!((e.rmse - (2.25_f64 / 5.0).sqrt()).abs() < 1e-12);
        assert!((e.mean_difference - 0.5).abs() < 1e-12);
        assert!((e.wrong_lit - 0.2).abs() < 1e-12 && (e.wrong_shadowed - 0.4).abs() < 1e-12);
        assert!((e.wrong() - 0.6).abs() < 1e-12);
    }

    #[test]
    fn factor_errors_count_only_selected_pixels() {
        let e = factor_errors(&[1.0, 0.0], &[0.0, 0.0], |i| i == 1).unwrap();
        assert_eq!(e, Some(FactorErrors { pixels: 1, ..FactorErrors::default() }));
    }

    #[test]
    fn factor_errors_without_pixels_are_none() {
        assert_eq!(factor_errors(&[1.0], &[0.0], |_| false).unwrap(), None);
    }

    #[test]
    fn factor_errors_refuse_different_lengths() {
        assert!(matches!(factor_errors(&[1.0], &[], |_| true), Err(Error::Sizes { .. })));
    }

    #[test]
    fn one_half_is_shadowed() {
        let e = factor_errors(&[0.5], &[1.0], |_| true).unwrap().unwrap();
        assert_eq!((e.wrong_lit, e.wrong_shadowed), (0.0, 1.0));
    }
}
