//! Structural similarity: Wang, Bovik, Sheikh, Simoncelli, *Image Quality Assessment: From Error Visibility
//! to Structural Similarity*, 2004.
//!
//! As in the paper: luma of 8-bit pictures (0.299 R + 0.587 G + 0.114 B), windows of 11 × 11 pixels weighted
//! by a Gaussian of σ 1.5, K1 = 0.01, K2 = 0.03, and the mean over every window that is entirely inside the
//! picture. No pixel is excluded.

use adumbra_truth::picture::Picture;
use rayon::prelude::*;

use crate::error::{Error, Result};

/// Width and height of a window in pixels.
const WINDOW: usize = 11;
const SIGMA: f64 = 1.5;
const C1: f64 = (0.01 * 255.0) * (0.01 * 255.0);
const C2: f64 = (0.03 * 255.0) * (0.03 * 255.0);

/// Returns the mean structural similarity of two pictures, 1 if they are equal.
///
/// Cost: about 0.1 µs per pixel.
///
/// # Errors
/// Returns [`Error::Sizes`] if the pictures differ in size, and [`Error::PictureTooSmall`] if they are less
/// than 11 pixels wide or high.
pub fn ssim(a: &Picture, b: &Picture) -> Result<f64> {
    Error::check_pictures(a, b)?;
    let (width, height) = (a.width as usize, a.height as usize);
    if width < WINDOW || height < WINDOW {
        return Err(Error::PictureTooSmall { width: a.width, height: a.height, least: WINDOW as u32 });
    }
    let weights = gaussian();
    let (luma_a, luma_b) = (luma(a), luma(b));
    let across: Vec<[f64; 5]> = (0..height)
        .into_par_iter()
        .flat_map_iter(|y| {
            let (row_a, row_b) = (&luma_a[y * width..], &luma_b[y * width..]);
            let weights = &weights;
            (0..=width - WINDOW).map(move |x| {
                let mut sums = [0.0; 5];
                for (k, w) in weights.iter().enumerate() {
                    let (p, q) = (row_a[x + k], row_b[x + k]);
                    for (sum, term) in sums.iter_mut().zip([p, q, p * p, q * q, p * q]) {
                        *sum += w * term;
                    }
                }
                sums
            })
        })
        .collect();
    let columns = width - WINDOW + 1;
    let row_sums: Vec<f64> = (0..=height - WINDOW)
        .into_par_iter()
        .map(|y| {
            let window = |x: usize| {
                let mut sums = [0.0; 5];
                for (k, w) in weights.iter().enumerate() {
                    for (sum, term) in sums.iter_mut().zip(across[(y + k) * columns + x]) {
                        *sum += w * term;
                    }
                }
                similarity(sums)
            };
            (0..columns).map(window).sum()
        })
        .collect();
    Ok(row_sums.iter().sum::<f64>() / (columns * row_sums.len()) as f64)
}

/// Returns the similarity of one window, from the weighted means of a, b, a², b², ab.
fn similarity([a, b, aa, bb, ab]: [f64; 5]) -> f64 {
    let (variance_a, variance_b, covariance) = (aa - a * a, bb - b * b, ab - a * b);
    (2.0 * a * b + C1) * (2.0 * covariance + C2) / ((a * a + b * b + C1) * (variance_a + variance_b + C2))
}

fn gaussian() -> [f64; WINDOW] {
    let middle = (WINDOW / 2) as f64;
    let raw: [f64; WINDOW] =
        std::array::from_fn(|i| libm::exp(-(i as f64 - middle).powi(2) / (2.0 * SIGMA * SIGMA)));
    let sum: f64 = raw.iter().sum();
    raw.map(|w| w / sum)
}

fn luma(picture: &Picture) -> Vec<f64> {
    let of = |p: &[u8; 3]| 0.299 * f64::from(p[0]) + 0.587 * f64::from(p[1]) + 0.114 * f64::from(p[2]);
    picture.rgb.as_chunks::<3>().0.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(width: u32, height: u32, value: impl Fn(u32, u32) -> u8) -> Picture {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let rgb = pixels.flat_map(|(x, y)| [value(x, y); 3]).collect();
        Picture { width, height, rgb, difference_share: None }
    }

    #[test]
    fn ssim_of_equal_pictures_is_one() {
        let a = picture(23, 17, |x, y| (x * 9 + y * 5) as u8);
        assert!((ssim(&a, &a).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn ssim_of_flat_pictures_is_the_luminance_term() {
        let (a, b) = (picture(12, 11, |_, _| 100), picture(12, 11, |_, _| 150));
        let expected = (2.0 * 100.0 * 150.0 + C1) / (100.0 * 100.0 + 150.0 * 150.0 + C1);
        assert!((ssim(&a, &b).unwrap() - expected).abs() < 1e-9);
    }

    #[test]
    fn ssim_of_a_negative_is_negative() {
        let wave = |x: u32, y: u32| if (x + y).is_multiple_of(2) { 60_u8 } else { 200 };
        let a = picture(20, 20, wave);
        let b = picture(20, 20, |x, y| 255 - wave(x, y));
        assert!(ssim(&a, &b).unwrap() < -0.9);
    }

    #[test]
    fn ssim_matches_the_window_summed_directly() {
        let a = picture(13, 12, |x, y| (x * x * 3 + y * 17) as u8);
        let b = picture(13, 12, |x, y| (x * x * 3 + y * 11 + x) as u8);
        let (w, la, lb) = (gaussian(), luma(&a), luma(&b));
        let mut mean = 0.0;
        for (y0, x0) in (0..2).flat_map(|y| (0..3).map(move |x| (y, x))) {
            let mut sums = [0.0; 5];
            for (j, i) in (0..11).flat_map(|j| (0..11).map(move |i| (j, i))) {
                let (p, q) = (la[(y0 + j) * 13 + x0 + i], lb[(y0 + j) * 13 + x0 + i]);
                for (s, t) in sums.iter_mut().zip([p, q, p * p, q * q, p * q]) {
                    *s += w[j] * w[i] * t;
                }
            }
            mean += similarity(sums) / 6.0;
        }
        assert!((ssim(&a, &b).unwrap() - mean).abs() < 1e-9);
    }

    #[test]
    fn ssim_rejects_pictures_smaller_than_its_window() {
        let a = picture(10, 40, |_, _| 0);
        assert!(matches!(ssim(&a, &a), Err(Error::PictureTooSmall { .. })));
        assert!(matches!(ssim(&a, &picture(11, 40, |_, _| 0)), Err(Error::Sizes { .. })));
    }
}
