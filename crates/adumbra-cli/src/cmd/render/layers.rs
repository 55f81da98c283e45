//! Layers of a frame as images: what a PNG shows of them, and the raw values that an EXR keeps.

use std::path::Path;

use adumbra::picture::Picture;
use adumbra::scene::{linear_to_srgb, srgb_to_linear};
use adumbra_render::SurfaceImage;

use crate::exit::Failure;
use crate::output::{write_exr, write_png};

/// A layer, row 0 at the top.
pub(in crate::cmd) struct Layer {
    pub(super) size: [u32; 2],
    /// Linear colours that a PNG shows.
    shown: Vec<[f32; 3]>,
    /// Whether the PNG keeps them as they are, without sRGB's curve.
    data: bool,
    /// Named channels with raw values.
    raw: Vec<(&'static str, Vec<f32>)>,
}

pub(super) fn color(size: [u32; 2], rgba: &[u8]) -> Layer {
    let shown: Vec<[f32; 3]> =
        rgba.as_chunks::<4>().0.iter().map(|p| [0, 1, 2].map(|c| srgb_to_linear(p[c]))).collect();
    let channel = |c: usize| shown.iter().map(|p| p[c]).collect();
    let raw = vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    Layer { size, raw, shown, data: false }
}

/// Visibilities: 1 is white.
pub(super) fn grey(size: [u32; 2], factor: Vec<f32>) -> Layer {
    Layer { size, shown: factor.iter().map(|&f| [f; 3]).collect(), data: true, raw: vec![("Y", factor)] }
}

/// Near is white; each halving of brightness is as far again as the nearest surface.
pub(super) fn depth(size: [u32; 2], view_depth: Vec<f32>) -> Layer {
    let nearest = view_depth.iter().copied().fold(f32::INFINITY, f32::min);
    let shown = view_depth.iter().map(|z| if z.is_finite() { [(nearest / z).sqrt(); 3] } else { [0.0; 3] });
    Layer { size, shown: shown.collect(), data: true, raw: vec![("Z", view_depth)] }
}

pub(super) fn normal(size: [u32; 2], surface: &SurfaceImage) -> Layer {
    let there: Vec<_> = surface.normal.iter().zip(&surface.view_depth).collect();
    let shown = there.iter().map(|(n, z)| if z.is_finite() { n.map(|c| 0.5 + 0.5 * c) } else { [0.0; 3] });
    let channel = |c: usize| there.iter().map(|(n, _)| n[c]).collect();
    let raw = vec![("N.X", channel(0)), ("N.Y", channel(1)), ("N.Z", channel(2))];
    Layer { size, shown: shown.collect(), data: true, raw }
}

/// A picture in the colours of what answers each pixel; below 0 nothing does.
pub(in crate::cmd) fn tinted(size: [u32; 2], rgba: &[u8], indices: Vec<f32>, colors: &[[f32; 3]]) -> Layer {
    let mut layer = color(size, rgba);
    for (shown, &index) in layer.shown.iter_mut().zip(&indices).filter(|(_, index)| **index >= 0.0) {
        let tint = colors[(index as usize).min(colors.len() - 1)];
        let grey = (shown[0] + shown[1] + shown[2]) / 3.0;
        *shown = tint.map(|t| t * (0.25 + 1.5 * grey));
    }
    layer.raw = vec![("Y", indices)];
    layer
}

impl Layer {
    /// The mean of `samples` × `samples` pixels each.
    pub(super) fn smaller(self, samples: u32) -> Self {
        if samples == 1 {
            return self;
        }
        let [width, height] = self.size.map(|s| s / samples);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let shown = pixels.map(|(x, y)| {
            let mut sum = [0.0; 3];
            for s in 0..samples * samples {
                let at = (y * samples + s / samples) * self.size[0] + x * samples + s % samples;
                let p = self.shown[at as usize];
                (0..3).for_each(|c| sum[c] += p[c]);
            }
            sum.map(|c| c / (samples * samples) as f32)
        });
        Self { size: [width, height], shown: shown.collect(), data: self.data, raw: Vec::new() }
    }

    /// What a PNG shows.
    pub(in crate::cmd) fn picture(&self) -> Picture {
        let [width, height] = self.size;
        let encode =
            |c: f32| if self.data { (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8 } else { linear_to_srgb(c) };
        let rgb = self.shown.iter().flat_map(|p| p.map(encode)).collect();
        Picture { width, height, rgb, difference_share: None }
    }
}

pub(super) fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// Writes a layer: raw values where the path ends in .exr, else a PNG.
pub(super) fn write(path: &Path, layer: &Layer) -> Result<(), Failure> {
    if is_exr(path) {
        return write_exr(path, layer.size, &layer.raw);
    }
    write_png(path, &layer.picture())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smaller_layer_is_the_mean() {
        let layer = grey([4, 2], vec![0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0]).smaller(2);
        assert_eq!((layer.size, layer.shown), ([2, 1], vec![[0.5; 3], [1.0; 3]]));
    }
}
