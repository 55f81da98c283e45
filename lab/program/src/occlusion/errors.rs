//! Errors of ambient visibility against the truth of the same radius, and the picture that SSIM and FLIP
//! compare.

use adumbra_truth::picture::Picture;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use adumbra_compare::error::{Error, Result};

/// Errors of ambient visibility over some pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OcclusionErrors {
    /// Number of pixels compared.
    pub pixels: u64,
    /// Root of the mean squared difference, 0 to 1.
    pub rmse: f64,
    /// Mean of estimate minus truth, -1 to 1. Positive values are too light.
    pub mean_signed: f64,
    /// Mean absolute difference, 0 to 1.
    pub mean_absolute: f64,
}

/// Compares `visibility` with `truth`, one value per pixel each, over the pixels for whose index `counts` is
/// true.
///
/// All errors are zero if no pixel counts.
///
/// # Errors
/// Returns [`Error::Sizes`] if the two differ in length.
pub fn occlusion_errors(
    visibility: &[f32],
    truth: &[f32],
    counts: impl Fn(usize) -> bool,
) -> Result<OcclusionErrors> {
    Error::check_sizes("visibility and truth", visibility.len(), truth.len())?;
    let (mut squares, mut sum, mut sizes, mut pixels) = (0.0, 0.0, 0.0, 0_u64);
    for (index, (&estimate, &right)) in visibility.iter().zip(truth).enumerate() {
        if !counts(index) {
            continue;
        }
        let difference = f64::from(estimate) - f64::from(right);
        pixels += 1;
        squares += difference * difference;
        sum += difference;
        sizes += difference.abs();
    }
    let whole = pixels.max(1) as f64;
    Ok(OcclusionErrors {
        pixels,
        rmse: (squares / whole).sqrt(),
        mean_signed: sum / whole,
        mean_absolute: sizes / whole,
    })
}

/// Returns visibility as a grey picture, in which a byte is 255 times the visibility clamped to 0 to 1.
///
/// No display transfer curve is applied, so that equal steps of visibility are equal steps of grey for image
/// metrics.
///
/// # Errors
/// Returns [`Error::Sizes`] if the number of visibility values differs from the number of pixels.
pub fn grey_picture([width, height]: [u32; 2], visibility: &[f32]) -> Result<Picture> {
    Error::check_sizes("visibility and pixels", visibility.len(), width as usize * height as usize)?;
    let rgb = visibility.iter().flat_map(|v| [(v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8; 3]).collect();
    Ok(Picture { width, height, rgb, difference_share: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use adumbra_compare::metrics::{flip, ssim};

    #[test]
    fn occlusion_errors_of_known_values() {
        let e = occlusion_errors(&[1.0, 0.5, 0.0, 0.25], &[0.5, 0.5, 0.25, 1.0], |i| i != 3).unwrap();
        assert_eq!(e.pixels, 3);
        assert!((e.rmse - (0.3125_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((e.mean_signed - 0.25 / 3.0).abs() < 1e-12, "too light is above 0");
        assert!((e.mean_absolute - 0.25).abs() < 1e-12);
    }

    #[test]
    fn occlusion_errors_without_pixels_are_zero_and_sizes_must_match() {
        assert_eq!(occlusion_errors(&[0.3], &[0.1], |_| false).unwrap(), OcclusionErrors::default());
        assert!(matches!(occlusion_errors(&[0.3], &[], |_| true), Err(Error::Sizes { .. })));
    }

    #[test]
    fn grey_picture_maps_visibility_linearly() {
        let picture = grey_picture([3, 1], &[-0.5, 0.5, 2.0]).unwrap();
        assert_eq!(picture.rgb, [0, 0, 0, 128, 128, 128, 255, 255, 255]);
        assert!(grey_picture([2, 1], &[0.0; 3]).is_err());
    }

    #[test]
    fn grey_pictures_are_compared_by_ssim_and_flip() {
        let size = [24, 24];
        let soft: Vec<f32> = (0..576).map(|i| (i % 24) as f32 / 23.0).collect();
        let a = grey_picture(size, &soft).unwrap();
        let darker: Vec<f32> = soft.iter().map(|v| 0.7 * v).collect();
        let b = grey_picture(size, &darker).unwrap();
        assert!((ssim(&a, &a).unwrap() - 1.0).abs() < 1e-9 && flip(&a, &a).unwrap() < 1e-6);
        assert!(ssim(&a, &b).unwrap() < 0.99 && flip(&a, &b).unwrap() > 0.02);
    }
}
