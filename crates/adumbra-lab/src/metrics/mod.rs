//! How far shadows are from the truth.
//!
//! RMSE and the wrong shares are taken on shadow factors, [`ssim()`] and [`flip()`] on composited sRGB pictures. A factor
//! above 1/2 is lit, in the answer and in the truth alike.

mod bands;
pub mod flip;
mod ssim;

pub use bands::{Band, bands};
pub use flip::flip;
use serde::{Deserialize, Serialize};
pub use ssim::ssim;

use crate::error::{Error, Result};

/// Errors of shadow factors over some pixels; shares are of those pixels, 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FactorErrors {
    /// Pixels compared.
    pub pixels: u64,
    /// Root of the mean squared difference, 0 to 1.
    pub rmse: f64,
    /// Mean of the difference's size, 0 to 1.
    pub mean_difference: f64,
    /// Share that is shadowed in truth and called lit, 0 to 1: light leaks.
    pub wrong_lit: f64,
    /// Share that is lit in truth and called shadowed, 0 to 1: acne.
    pub wrong_shadowed: f64,
}

impl FactorErrors {
    /// Share of the pixels on the wrong side of 1/2.
    pub fn wrong(&self) -> f64 {
        self.wrong_lit + self.wrong_shadowed
    }
}

/// Whether a factor counts as lit.
pub fn is_lit(factor: f32) -> bool {
    factor > 0.5
}

/// Compares `factors` with `truth`, both one a pixel, where `counts` holds of the pixel's index; none where it holds of none.
///
/// # Errors
/// [`Error::Sizes`] where the two differ in length.
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
    fn factor_errors_count_only_what_is_asked_for() {
        let e = factor_errors(&[1.0, 0.0], &[0.0, 0.0], |i| i == 1).unwrap();
        assert_eq!(e, Some(FactorErrors { pixels: 1, ..FactorErrors::default() }));
    }

    #[test]
    fn nothing_compared_has_no_figures() {
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
