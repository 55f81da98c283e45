//! The claims of Qiu et al. (2014) about their estimator as numbers: detail, self-occlusion, clean edges
//! after filtering.
//!
//! The high pass of a picture is the picture minus its Gaussian mean over [`BLUR_PIXELS`]. The mean is taken
//! only over pixels that count.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::errors::occlusion_errors;
use super::measure::TracedView;
use adumbra_compare::error::{Error, Result};
use adumbra_compare::truth::Surfaces;
use adumbra_compare::vector::dot;

/// Standard deviation of the Gaussian in pixels.
pub(crate) const BLUR_PIXELS: f64 = 8.0;
/// Truth above this visibility is open: any occlusion there is self-occlusion or noise.
pub const OPEN: f32 = 0.98;
/// Distance in pixels up to which pixels near a discontinuity are its edge.
pub(crate) const EDGE_PIXELS: usize = 3;
/// Neighbouring pixels are discontinuous if one is further than this from the plane of the other, in radii...
pub(crate) const EDGE_STEP: f64 = 0.1;
/// ...or if the cosine between their normals is smaller than this.
pub(crate) const EDGE_COSINE: f64 = 0.7;
/// Truth is flat where the root mean square of its high pass around the pixel is smaller than this.
pub const FLAT: f64 = 0.02;

/// The numbers of one picture, each `None` if no pixel is of its kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Claims {
    /// Correlation of the high pass with the truth's, -1 to 1.
    pub detail_correlation: Option<f64>,
    /// Variance of the high pass divided by that of the truth's: below 1 is blurred, above 1 is noisy or too
    /// strong.
    pub detail_variance: Option<f64>,
    /// Mean occlusion, 1 - visibility, where truth is open.
    pub self_occlusion: Option<f64>,
    /// RMSE on edges, 0 to 1.
    pub edge_rmse: Option<f64>,
    /// Root mean square of the high pass, in visibility, where truth is flat and no edge is near.
    pub noise: Option<f64>,
}

/// The pixels of a truth sorted by kind.
pub struct ClaimProbe<'a> {
    traced_view: &'a TracedView,
    high_pass: Vec<f64>,
    edges: Vec<bool>,
    flat: Vec<bool>,
}

impl<'a> ClaimProbe<'a> {
    /// Sorts the pixels of a truth of the given radius. Cost: about 0.3 µs per pixel.
    pub fn new(traced_view: &'a TracedView, radius_world: f64) -> Self {
        let size = [traced_view.surfaces.width as usize, traced_view.surfaces.height as usize];
        let mut edges = discontinuities(&traced_view.surfaces, EDGE_STEP * radius_world);
        widen(&mut edges, size);
        let high_pass = high_pass(size, &traced_view.truth, &traced_view.counted);
        let squares: Vec<f64> = high_pass.iter().map(|h| h * h).collect();
        let around = blurred(size, &squares, &traced_view.counted);
        let flat = (0..edges.len()).map(|i| traced_view.counted[i] && !edges[i] && around[i] < FLAT * FLAT);
        let flat = flat.collect();
        for (edge, counted) in edges.iter_mut().zip(&traced_view.counted) {
            *edge &= *counted;
        }
        Self { traced_view, high_pass, edges, flat }
    }

    /// Returns the shares of the counted pixels that are on edges, and that are flat.
    pub fn shares(&self) -> [f64; 2] {
        let count = |kind: &[bool]| kind.iter().filter(|k| **k).count() as f64;
        let whole = count(&self.traced_view.counted).max(1.0);
        [count(&self.edges) / whole, count(&self.flat) / whole]
    }

    /// Returns the numbers of a picture. Those of the truth itself are the floor set by the noise of its
    /// rays.
    ///
    /// # Errors
    /// Returns [`Error::Sizes`] if the visibility and the truth differ in their number of pixels.
    pub fn claims(&self, visibility: &[f32]) -> Result<Claims> {
        let TracedView { surfaces, truth, counted, .. } = self.traced_view;
        Error::check_sizes("visibility and truth", visibility.len(), truth.len())?;
        let high = high_pass([surfaces.width as usize, surfaces.height as usize], visibility, counted);
        let pixels = || (0..high.len()).filter(|&i| counted[i]);
        let count = pixels().count().max(1) as f64;
        let mean = |of: &[f64]| pixels().map(|i| of[i]).sum::<f64>() / count;
        let (own, other) = (mean(&high), mean(&self.high_pass));
        let product = |a: (&[f64], f64), b: (&[f64], f64)| {
            pixels().map(|i| (a.0[i] - a.1) * (b.0[i] - b.1)).sum::<f64>() / count
        };
        let (own, other) = ((high.as_slice(), own), (self.high_pass.as_slice(), other));
        let [both, variance, right] = [product(own, other), product(own, own), product(other, other)];
        let open = |i: usize| counted[i] && truth[i] > OPEN;
        let closed = mean_where(open, |i| 1.0 - f64::from(visibility[i]), high.len());
        let edge = occlusion_errors(visibility, truth, |i| self.edges[i])?;
        Ok(Claims {
            detail_correlation: (variance > 0.0 && right > 0.0).then(|| both / (variance * right).sqrt()),
            detail_variance: (right > 0.0).then(|| variance / right),
            self_occlusion: closed,
            edge_rmse: (edge.pixels > 0).then_some(edge.rmse),
            noise: mean_where(|i| self.flat[i], |i| high[i] * high[i], high.len()).map(f64::sqrt),
        })
    }
}

fn mean_where(counts: impl Fn(usize) -> bool, value: impl Fn(usize) -> f64, length: usize) -> Option<f64> {
    let (mut sum, mut pixels) = (0.0, 0_u64);
    for i in (0..length).filter(|i| counts(*i)) {
        sum += value(i);
        pixels += 1;
    }
    (pixels > 0).then(|| sum / pixels as f64)
}

/// Marks the pixels on both sides of every discontinuity between neighbours.
fn discontinuities(surfaces: &Surfaces, step_world: f64) -> Vec<bool> {
    let [width, height] = [surfaces.width as usize, surfaces.height as usize];
    let broken = |i: usize, j: usize| {
        if !surfaces.is_valid(i) || !surfaces.is_valid(j) {
            return surfaces.is_valid(i) != surfaces.is_valid(j);
        }
        let normals = [i, j].map(|k| surfaces.normal[k].map(f64::from));
        let between: [f64; 3] = std::array::from_fn(|a| surfaces.position[j][a] - surfaces.position[i][a]);
        let off = normals.iter().map(|n| dot(*n, between).abs()).fold(0.0, f64::max);
        off > step_world || dot(normals[0], normals[1]) < EDGE_COSINE
    };
    let mut edges = vec![false; width * height];
    for (i, (x, y)) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).enumerate() {
        for j in [(x + 1 < width).then_some(i + 1), (y + 1 < height).then_some(i + width)] {
            if let Some(j) = j.filter(|j| broken(i, *j)) {
                edges[i] = true;
                edges[j] = true;
            }
        }
    }
    edges
}

/// Dilates `edges` so that [`EDGE_PIXELS`] pixels on either side of a discontinuity are set.
fn widen(edges: &mut Vec<bool>, [width, height]: [usize; 2]) {
    let reach = EDGE_PIXELS - 1;
    let near = |from: &[bool], at: usize, length: usize, index: &dyn Fn(usize) -> usize| {
        (at.saturating_sub(reach)..(at + reach + 1).min(length)).any(|k| from[index(k)])
    };
    let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let along: Vec<bool> = pixels().map(|(x, y)| near(edges, x, width, &|k| y * width + k)).collect();
    *edges = pixels().map(|(x, y)| near(&along, y, height, &|k| k * width + x)).collect();
}

/// Returns the picture minus its blurred version at pixels that count, 0 elsewhere.
fn high_pass(size: [usize; 2], visibility: &[f32], counted: &[bool]) -> Vec<f64> {
    let values: Vec<f64> = visibility.iter().map(|v| f64::from(*v)).collect();
    let low = blurred(size, &values, counted);
    (0..values.len()).map(|i| if counted[i] { values[i] - low[i] } else { 0.0 }).collect()
}

/// Returns the Gaussian mean over the pixels that count, 0 where none is in reach.
fn blurred([width, height]: [usize; 2], values: &[f64], counted: &[bool]) -> Vec<f64> {
    let reach = (3.0 * BLUR_PIXELS) as usize;
    let weights: Vec<f64> = (0..=reach).map(|d| libm::exp(-0.5 * (d as f64 / BLUR_PIXELS).powi(2))).collect();
    let line = |from: &[[f64; 2]], at: usize, length: usize, index: &dyn Fn(usize) -> usize| {
        let taps = at.saturating_sub(reach)..(at + reach + 1).min(length);
        taps.fold([0.0; 2], |[sum, whole], k| {
            let ([v, w], weight) = (from[index(k)], weights[k.abs_diff(at)]);
            [sum + weight * v, whole + weight * w]
        })
    };
    let pass = |from: &[[f64; 2]], down: bool| -> Vec<[f64; 2]> {
        let pixel = |i: usize| {
            let (x, y) = (i % width, i / width);
            if down {
                line(from, y, height, &|k| k * width + x)
            } else {
                line(from, x, width, &|k| y * width + k)
            }
        };
        (0..values.len()).into_par_iter().map(pixel).collect()
    };
    let counted: Vec<[f64; 2]> =
        values.iter().zip(counted).map(|(v, c)| if *c { [*v, 1.0] } else { [0.0; 2] }).collect();
    let both = pass(&pass(&counted, false), true);
    both.into_iter().map(|[sum, whole]| if whole > 0.0 { sum / whole } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use adumbra_compare::report::PixelCounts;

    const SIZE: [u32; 2] = [96, 64];

    /// Returns a plane facing the camera with a step at x = 48.
    ///
    /// The truth is a wave except for an open strip and a flat one.
    fn traced_view() -> TracedView {
        let [width, height] = SIZE;
        let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let position =
            pixels().map(|(x, y)| [f64::from(x), f64::from(y), if x < 48 { 0.0 } else { 5.0 }]).collect();
        let truth = |(x, y): (u32, u32)| match y {
            0..20 => 1.0,
            _ if x > 60 => 0.5,
            _ => 0.5 + 0.3 * libm::sinf(x as f32),
        };
        TracedView {
            surfaces: Surfaces {
                width,
                height,
                position,
                normal: vec![[0.0, 0.0, 1.0]; (width * height) as usize],
                view_depth: vec![10.0; (width * height) as usize],
                lift_world: vec![0.0; (width * height) as usize],
            },
            truth: pixels().map(truth).collect(),
            counted: vec![true; (width * height) as usize],
            pixels: PixelCounts::default(),
        }
    }

    #[test]
    fn claims_of_truth_have_no_error() {
        let traced_view = traced_view();
        let probe = ClaimProbe::new(&traced_view, 10.0);
        let c = probe.claims(&traced_view.truth).unwrap();
        assert!((c.detail_correlation.unwrap() - 1.0).abs() < 1e-9);
        assert!((c.detail_variance.unwrap() - 1.0).abs() < 1e-9);
        assert_eq!((c.self_occlusion, c.edge_rmse), (Some(0.0), Some(0.0)));
        assert!(c.noise.unwrap() < FLAT, "{c:?}");
        let [edges, flat] = probe.shares();
        // Three pixels on either side of the step.
        assert!((edges - 6.0 / 96.0).abs() < 1e-9, "{edges}");
        assert!(flat > 0.03 && flat < 0.7, "{flat}");
    }

    #[test]
    fn claims_detect_blur_noise_and_darkness() {
        let traced_view = traced_view();
        let probe = ClaimProbe::new(&traced_view, 10.0);
        let size = SIZE.map(|s| s as usize);
        let truth: Vec<f64> = traced_view.truth.iter().map(|v| f64::from(*v)).collect();
        let low: Vec<f32> = blurred(size, &truth, &traced_view.counted).iter().map(|v| *v as f32).collect();
        let blur = probe.claims(&low).unwrap();
        assert!(blur.detail_variance.unwrap() < 0.3 && blur.edge_rmse.unwrap() > 0.1, "{blur:?}");
        let darker: Vec<f32> = traced_view.truth.iter().map(|v| v - 0.1).collect();
        let darker = probe.claims(&darker).unwrap();
        assert!((darker.self_occlusion.unwrap() - 0.1).abs() < 1e-6, "{darker:?}");
        assert!((darker.edge_rmse.unwrap() - 0.1).abs() < 1e-6);
        assert!((darker.detail_correlation.unwrap() - 1.0).abs() < 1e-6);
        let noisy: Vec<f32> = traced_view
            .truth
            .iter()
            .enumerate()
            .map(|(i, v)| v + if i % 3 == 0 { 0.2 } else { -0.1 })
            .collect();
        let noisy = probe.claims(&noisy).unwrap();
        assert!((noisy.noise.unwrap() - 0.02_f64.sqrt()).abs() < 0.02, "{noisy:?}");
        assert!(noisy.detail_correlation.unwrap() < 0.9 && noisy.detail_variance.unwrap() > 1.1, "{noisy:?}");
    }

    #[test]
    fn claims_without_counted_pixels_are_none() {
        let mut traced_view = traced_view();
        traced_view.counted.fill(false);
        let probe = ClaimProbe::new(&traced_view, 10.0);
        assert_eq!(probe.claims(&traced_view.truth).unwrap(), Claims::default());
        assert!(probe.claims(&[1.0]).is_err());
    }
}
