//! Errors away from shadow edges, over a sample of the compared pixels. Wrong pixels and the total are
//! counted over the same sample.

use rayon::prelude::*;

use crate::metrics::is_lit;
use crate::report::ClearErrors;
use crate::truth::{EdgeProbe, Surfaces};

/// Required distance from an edge, in texels of the technique.
pub const CLEAR_TEXELS: f64 = 2.0;
/// Largest number of pixels examined. Of more pixels, every second, third, … is examined.
const MAX_PIXELS: usize = 1 << 16;

/// Returns the errors of `factors` at the compared pixels that are more than [`CLEAR_TEXELS`] texels from an
/// edge.
///
/// `texel_world` gives the texel size at a pixel in world units. Returns `None` if there is no such pixel, or
/// if a compared pixel has no texel size.
///
/// Cost: up to 17 rays per pixel, for at most 65,536 pixels.
pub(crate) fn clear_errors(
    probe: &EdgeProbe<'_, '_>,
    surfaces: &Surfaces,
    (factors, truth): (&[f32], &[f32]),
    is_compared: impl Fn(usize) -> bool,
    texel_world: impl Fn(usize) -> Option<f64>,
) -> Option<ClearErrors> {
    let pixels: Vec<(usize, f64)> = (0..factors.len())
        .filter(|&i| is_compared(i))
        .map(|i| texel_world(i).map(|texel| (i, CLEAR_TEXELS * texel)))
        .collect::<Option<_>>()?;
    let step = pixels.len().div_ceil(MAX_PIXELS).max(1);
    let sample: Vec<(usize, f64)> = pixels.into_iter().step_by(step).collect();
    let is_clear = |&&(i, radius): &&(usize, f64)| {
        probe.is_clear(surfaces.lifted(i), surfaces.normal[i].map(f64::from), radius)
    };
    let clear: Vec<usize> = sample.par_iter().filter(is_clear).map(|&(i, _)| i).collect();
    let wrong = |lit: bool| {
        let found = clear.iter().filter(|&&i| is_lit(factors[i]) == lit && is_lit(truth[i]) != lit).count();
        found as f64 / clear.len() as f64
    };
    (!clear.is_empty()).then(|| ClearErrors {
        pixels: clear.len() as f64 / sample.len() as f64,
        wrong_lit: wrong(true),
        wrong_shadowed: wrong(false),
    })
}
