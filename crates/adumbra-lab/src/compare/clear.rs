//! Errors away from shadow edges, over a sample of the compared pixels: whoever is counted as wrong is counted in the whole too.

use rayon::prelude::*;

use crate::metrics::is_lit;
use crate::report::ClearErrors;
use crate::truth::{EdgeProbe, Surfaces};

/// How far from an edge, in the technique's texels.
pub const CLEAR_TEXELS: f64 = 2.0;
/// Of more pixels than these, every second, third, … is asked, so that at most so many are.
const MOST_PIXELS: usize = 1 << 16;

/// Errors of `factors` at the pixels that are `judged` and lie [`CLEAR_TEXELS`] texels from an edge; `texel_world` gives a pixel's. None where
/// no pixel lies so, or a pixel has no texel. Cost: 17 rays a pixel, of at most 65,536.
pub fn clear_errors(
    probe: &EdgeProbe<'_, '_>,
    surfaces: &Surfaces,
    (factors, truth): (&[f32], &[f32]),
    judged: impl Fn(usize) -> bool,
    texel_world: impl Fn(usize) -> Option<f64>,
) -> Option<ClearErrors> {
    let pixels: Vec<(usize, f64)> = (0..factors.len())
        .filter(|&i| judged(i))
        .map(|i| texel_world(i).map(|texel| (i, CLEAR_TEXELS * texel)))
        .collect::<Option<_>>()?;
    let step = pixels.len().div_ceil(MOST_PIXELS).max(1);
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
