//! Errors away from shadow edges: only pixels that are wrong are asked about their neighbourhood, and a sample of all, so that
//! nearly no rays are cast.

use rayon::prelude::*;

use crate::metrics::is_lit;
use crate::report::ClearErrors;
use crate::truth::{EdgeProbe, Surfaces};

/// How far from an edge, in the technique's texels.
pub const CLEAR_TEXELS: f64 = 2.0;
/// Every so many pixels tell how many lie clear.
const SAMPLE: usize = 29;

/// Errors of `factors` at the pixels that are `judged` and lie [`CLEAR_TEXELS`] texels from an edge; `texel_world` gives a pixel's.
/// Cost: 17 rays for each wrong pixel and for every 29th.
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
    let clear = |&&(i, radius): &&(usize, f64)| {
        probe.is_clear(surfaces.lifted(i), surfaces.normal[i].map(f64::from), radius)
    };
    let sample: Vec<(usize, f64)> = pixels.iter().copied().step_by(SAMPLE).collect();
    let share = sample.par_iter().filter(clear).count() as f64 / sample.len().max(1) as f64;
    let count = share * pixels.len() as f64;
    let wrong = |lit: bool| {
        let found = pixels
            .par_iter()
            .filter(|(i, _)| is_lit(factors[*i]) == lit && is_lit(truth[*i]) != lit)
            .filter(clear)
            .count();
        if count > 0.0 { found as f64 / count } else { 0.0 }
    };
    Some(ClearErrors { pixels: share, wrong_lit: wrong(true), wrong_shadowed: wrong(false) })
}
