//! Separable filters on planes of `f32`, with border pixels repeated outwards.

use rayon::prelude::*;

/// One value per pixel, with row 0 at the top.
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) values: Vec<f32>,
}

/// Filter weights at offsets from -radius to radius.
pub(super) struct Kernel(Vec<f32>);

impl Kernel {
    pub(super) fn new(radius: usize, weight: impl Fn(f64) -> f64) -> Self {
        let radius = radius as i64;
        Self((-radius..=radius).map(|x| weight(x as f64) as f32).collect())
    }
}

impl Plane {
    pub(super) fn new(width: usize, values: Vec<f32>) -> Self {
        Self { width, values }
    }

    /// Returns the plane filtered by `across` along rows, then by `down` along columns.
    pub(super) fn filtered(&self, across: &Kernel, down: &Kernel) -> Self {
        let (width, height) = (self.width, self.values.len() / self.width);
        let mut middle = vec![0.0; self.values.len()];
        middle.par_chunks_mut(width).zip(self.values.par_chunks(width)).for_each(|(out, row)| {
            let radius = across.0.len() / 2;
            for (x, value) in out.iter_mut().enumerate() {
                let at = |k: usize| row[(x + k).saturating_sub(radius).min(width - 1)];
                *value = across.0.iter().enumerate().map(|(k, w)| w * at(k)).sum();
            }
        });
        let mut values = vec![0.0_f32; self.values.len()];
        values.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
            let radius = down.0.len() / 2;
            for (k, w) in down.0.iter().enumerate() {
                let row = (y + k).saturating_sub(radius).min(height - 1);
                for (value, term) in out.iter_mut().zip(&middle[row * width..]) {
                    *value += w * term;
                }
            }
        });
        Self { width, values }
    }
}
