//! Ray-traced truth of ambient occlusion at each pixel: cosine-weighted rays up to a radius, against every
//! caster.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::{Surfaces, TruthTracer};

/// Offset of the seeds of a second, independent set of rays. No picture has this many pixels.
const SECOND: u64 = 1 << 40;

impl TruthTracer<'_> {
    /// Returns the ambient visibility of each pixel: the cosine-weighted share of the hemisphere above its
    /// surface in which no caster is within `radius_world`.
    ///
    /// It traces `rays` cosine-weighted rays from [`Surfaces::lifted`], seeded by the pixel's index. Pixels
    /// without a surface have 1, and so do all pixels if `rays` is 0 or the radius is not above 0.
    ///
    /// Cost: `rays` rays per pixel with a surface, about 0.3 µs each. Rows run in parallel on the current
    /// rayon pool.
    pub fn ambient(&self, surfaces: &Surfaces, radius_world: f64, rays: u32) -> Vec<f32> {
        self.ambient_unless(surfaces, radius_world, rays, &AtomicBool::new(false))
    }

    /// Computes [`Self::ambient`], with 1 at pixels that are not traced yet when `cancel` is set.
    pub fn ambient_unless(
        &self,
        surfaces: &Surfaces,
        radius_world: f64,
        rays: u32,
        cancel: &AtomicBool,
    ) -> Vec<f32> {
        let width = surfaces.width as usize;
        let mut visibility = vec![1.0; surfaces.pixels()];
        visibility.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            for (x, visibility) in row.iter_mut().enumerate() {
                if !cancel.load(Ordering::Relaxed) {
                    *visibility = self.ambient_at(surfaces, y * width + x, radius_world, rays, 0);
                }
            }
        });
        visibility
    }

    /// Measures the standard error of [`Self::ambient`].
    ///
    /// Every `every`-th pixel with a surface is traced a second time with other rays. The error is the
    /// root-mean-square difference between both, divided by √2. Returns `None` if no pixel is traced.
    ///
    /// Cost: `rays` rays per traced pixel.
    pub fn measured_error(
        &self,
        surfaces: &Surfaces,
        ambient: &[f32],
        radius_world: f64,
        rays: u32,
        every: usize,
    ) -> Option<f64> {
        let valid = (0..surfaces.pixels().min(ambient.len())).filter(|&i| surfaces.is_valid(i));
        let pixels: Vec<usize> = valid.step_by(every.max(1)).collect();
        let square = |&i: &usize| {
            let second = self.ambient_at(surfaces, i, radius_world, rays, SECOND);
            (f64::from(second) - f64::from(ambient[i])).powi(2)
        };
        let squares: Vec<f64> = pixels.par_iter().map(square).collect();
        let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
        (!squares.is_empty()).then(|| (0.5 * mean).sqrt())
    }

    fn ambient_at(&self, surfaces: &Surfaces, i: usize, radius_world: f64, rays: u32, seeds: u64) -> f32 {
        // NaN counts as no radius.
        if !surfaces.is_valid(i) || radius_world.is_nan() || radius_world <= 0.0 {
            return 1.0;
        }
        let normal = surfaces.normal[i].map(f64::from);
        self.tracer.ambient_visibility(surfaces.lifted(i), normal, radius_world, rays, seeds + i as u64)
    }
}

/// Returns an upper bound of the standard error of visibility that was measured with `rays` rays per pixel,
/// over the pixels for whose index `counts` holds.
///
/// It is the root of the mean of p (1 - p) / `rays`, the error of independent rays. The stratified rays of
/// [`TruthTracer::ambient`] have a smaller error. The bound is 0 if no pixel counts.
pub fn standard_error(visibility: &[f32], rays: u32, counts: impl Fn(usize) -> bool) -> f64 {
    let (mut sum, mut pixels) = (0.0, 0_u64);
    for (_, &p) in visibility.iter().enumerate().filter(|(i, _)| counts(*i)) {
        let p = f64::from(p).clamp(0.0, 1.0);
        sum += p * (1.0 - p);
        pixels += 1;
    }
    (sum / pixels.max(1) as f64 / f64::from(rays.max(1))).sqrt()
}
