//! FLIP for low-dynamic-range pictures: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild,
//! *FLIP: A Difference Evaluator for Alternating Images*, 2020. Implemented from the paper and tested against
//! its authors' program.
//!
//! Each pixel goes through two pipelines. The colour pipeline filters both pictures with the contrast
//! sensitivity of the eye, compares them in CIELAB, and maps the distance to 0…1. The feature pipeline finds
//! edges and points of the luminance with derivatives of a Gaussian. The feature difference amplifies the
//! colour difference: `ΔE = ΔEc^(1 - ΔEf)`. Unlike in the paper, every filter runs as separable passes, which
//! is equivalent because the filters are separable.

mod color;
mod filter;

use std::f64::consts::PI;

use adumbra_truth::picture::Picture;
use color::{hunt_lab_from_linear, hyab, linear_from_srgb8, linear_from_ycxcz, ycxcz_from_linear};
use filter::{Kernel, Plane};
use rayon::prelude::*;

use crate::error::{Error, Result};

/// Pixels per degree of visual angle: a screen 0.7 m wide with 3840 pixels, seen from 0.7 m.
pub const PIXELS_PER_DEGREE: f64 = 67.0;

/// Heights and widths (degrees²) of the Gaussians whose sums are the eye's contrast sensitivity to luminance,
/// red-green and blue-yellow.
const SENSITIVITY: [[[f64; 2]; 2]; 3] =
    [[[1.0, 0.0047], [0.0, 1e-5]], [[1.0, 0.0053], [0.0, 1e-5]], [[34.1, 0.04], [13.5, 0.025]]];
/// Exponent of colour distances.
const Q_COLOR: f32 = 0.7;
/// Share of the largest distance below which distances map linearly to 0…[`P_TOP`]. Larger ones map to the
/// rest.
const P_LARGE: f32 = 0.4;
const P_TOP: f32 = 0.95;
/// Exponent of feature differences.
const Q_FEATURE: f32 = 0.5;
/// Width of a feature, in degrees of visual angle.
const FEATURE_DEGREES: f64 = 0.082;

/// Returns the mean difference that a viewer at [`PIXELS_PER_DEGREE`] sees when flipping between two
/// pictures: 0 for equal ones, 1 for black and white.
///
/// Cost: about 1 µs per pixel. Runs on the current rayon pool.
///
/// # Errors
/// Returns [`Error::Sizes`] if the pictures differ in size.
pub fn flip(reference: &Picture, test: &Picture) -> Result<f64> {
    let map = flip_map(reference, test, PIXELS_PER_DEGREE)?;
    Ok(map.iter().map(|e| f64::from(*e)).sum::<f64>() / map.len().max(1) as f64)
}

/// Returns the difference at each pixel, 0 to 1.
///
/// # Errors
/// Returns [`Error::Sizes`] if the pictures differ in size.
pub fn flip_map(reference: &Picture, test: &Picture, pixels_per_degree: f64) -> Result<Vec<f32>> {
    Error::check_pictures(reference, test)?;
    let eyes = [reference, test].map(|picture| PerceivedImage::new(picture, pixels_per_degree));
    let [a, b] = &eyes;
    let green = hunt_lab_from_linear([0.0, 1.0, 0.0]);
    let blue = hunt_lab_from_linear([0.0, 0.0, 1.0]);
    let largest = libm::powf(hyab(green, blue), Q_COLOR);
    let pixel = |i: usize| {
        let distance = libm::powf(hyab(a.color[i], b.color[i]), Q_COLOR);
        let knee = P_LARGE * largest;
        let color = if distance < knee {
            P_TOP * distance / knee
        } else {
            P_TOP + (1.0 - P_TOP) * (distance - knee) / (largest - knee)
        };
        let step = (0..2).map(|f| (a.features[i][f] - b.features[i][f]).abs()).fold(0.0, f32::max);
        let feature = libm::powf(step * std::f32::consts::FRAC_1_SQRT_2, Q_FEATURE).clamp(0.0, 1.0);
        libm::powf(color, 1.0 - feature)
    };
    Ok((0..a.color.len()).into_par_iter().map(pixel).collect())
}

/// A picture as the eye perceives it.
struct PerceivedImage {
    /// Filtered colours in CIELAB with the Hunt adjustment.
    color: Vec<[f32; 3]>,
    /// Strength of edges and of points.
    features: Vec<[f32; 2]>,
}

impl PerceivedImage {
    fn new(picture: &Picture, pixels_per_degree: f64) -> Self {
        let width = picture.width as usize;
        let table: Vec<f32> = (0..=255).map(linear_from_srgb8).collect();
        let pixels = picture.rgb.as_chunks::<3>().0;
        let ycxcz: Vec<[f32; 3]> =
            pixels.par_iter().map(|p| ycxcz_from_linear(p.map(|c| table[usize::from(c)]))).collect();
        let plane = |channel: usize| Plane::new(width, ycxcz.iter().map(|c| c[channel]).collect());
        let filtered: [Plane; 3] =
            std::array::from_fn(|c| sensed(&plane(c), &SENSITIVITY[c], pixels_per_degree));
        let color = (0..ycxcz.len())
            .into_par_iter()
            .map(|i| {
                let linear = linear_from_ycxcz(std::array::from_fn(|c| filtered[c].values[i]));
                hunt_lab_from_linear(linear.map(|c| c.clamp(0.0, 1.0)))
            })
            .collect();
        let luminance = Plane::new(width, ycxcz.iter().map(|c| (c[0] + 16.0) / 116.0).collect());
        Self { color, features: features(&luminance, pixels_per_degree) }
    }
}

/// Filters a plane with the sum of two Gaussians, normalised so that all weights sum to 1.
fn sensed(plane: &Plane, gaussians: &[[f64; 2]; 2], pixels_per_degree: f64) -> Plane {
    // The widest Gaussian of all channels determines the radius of every filter.
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
    let bell = |width: f64, x: f64| libm::exp(-PI * PI * (x / pixels_per_degree).powi(2) / width);
    let height = |[a, width]: [f64; 2]| a * (PI / width).sqrt();
    let side = |width: f64| (-(radius as i64)..=radius as i64).map(|x| bell(width, x as f64)).sum::<f64>();
    let whole: f64 = gaussians.iter().map(|g| height(*g) * side(g[1]).powi(2)).sum();
    let mut sum = Plane::new(plane.width, vec![0.0; plane.values.len()]);
    for gaussian in gaussians.iter().filter(|g| g[0] > 0.0) {
        // The square root, because the kernel is applied to rows and to columns.
        let scale = (height(*gaussian) / whole).sqrt();
        let kernel = Kernel::new(radius, |x| scale * bell(gaussian[1], x));
        let part = plane.filtered(&kernel, &kernel);
        sum.values.iter_mut().zip(part.values).for_each(|(s, p)| *s += p);
    }
    sum
}

/// Returns the strength of edges and points at each pixel of a luminance of 0…1.
fn features(luminance: &Plane, pixels_per_degree: f64) -> Vec<[f32; 2]> {
    let deviation = 0.5 * FEATURE_DEGREES * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as usize;
    let bell = |x: f64| libm::exp(-x * x / (2.0 * deviation * deviation));
    let taps = || (-(radius as i64)..=radius as i64).map(|x| x as f64);
    let bell_sum: f64 = taps().map(bell).sum();
    let smooth = Kernel::new(radius, |x| bell(x) / bell_sum);
    // Kernels of the first and second derivative. Positive weights sum to 1, negative ones to -1.
    let derivative = |weight: &dyn Fn(f64) -> f64| {
        let part = |sign: f64| taps().map(|x| (sign * weight(x)).max(0.0)).sum::<f64>();
        let (positive, negative) = (part(1.0), part(-1.0));
        Kernel::new(radius, |x| weight(x) / if weight(x) > 0.0 { positive } else { negative })
    };
    let edge = derivative(&|x| -x * bell(x));
    let point = derivative(&|x| (x * x / (deviation * deviation) - 1.0) * bell(x));
    let [edges, points] = [edge, point].map(|kernel| {
        let (x, y) = (luminance.filtered(&kernel, &smooth), luminance.filtered(&smooth, &kernel));
        x.values.into_iter().zip(y.values).map(|(x, y)| (x * x + y * y).sqrt()).collect::<Vec<f32>>()
    });
    edges.into_iter().zip(points).map(|(e, p)| [e, p]).collect()
}
