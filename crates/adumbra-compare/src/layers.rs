//! Layers of a frame as images: displayable colours for PNG, and raw values for EXR.

use std::path::Path;

use adumbra_program::exit::Failure;
use adumbra_program::output::{write_png, write_whole};
use adumbra_render::SurfaceImage;
use adumbra_scene::{linear_to_srgb, srgb_to_linear};
use adumbra_truth::picture::Picture;

use crate::Result;

/// A layer, with row 0 at the top.
pub struct Layer {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Linear colours of the PNG.
    shown: Vec<[f32; 3]>,
    /// Whether the PNG stores them without the sRGB transfer function.
    data: bool,
    /// Named channels of raw values, for the EXR.
    raw: Vec<(&'static str, Vec<f32>)>,
}

/// Returns a layer of a finished picture.
pub fn color(size: [u32; 2], rgba: &[u8]) -> Layer {
    let shown: Vec<[f32; 3]> =
        rgba.as_chunks::<4>().0.iter().map(|p| [0, 1, 2].map(|c| srgb_to_linear(p[c]))).collect();
    let channel = |c: usize| shown.iter().map(|p| p[c]).collect();
    let raw = vec![("R", channel(0)), ("G", channel(1)), ("B", channel(2))];
    Layer { size, raw, shown, data: false }
}

/// Returns a layer of visibilities, with 1 shown as white.
pub fn grey(size: [u32; 2], factor: Vec<f32>) -> Layer {
    Layer { size, shown: factor.iter().map(|&f| [f; 3]).collect(), data: true, raw: vec![("Y", factor)] }
}

/// Returns a layer of view depths. Its PNG shows `sqrt(nearest / depth)`: the nearest surface is white, the
/// value is halved at four times its depth, and the background is black.
pub fn depth(size: [u32; 2], view_depth: Vec<f32>) -> Layer {
    let nearest = view_depth.iter().copied().fold(f32::INFINITY, f32::min);
    let shown = view_depth.iter().map(|z| if z.is_finite() { [(nearest / z).sqrt(); 3] } else { [0.0; 3] });
    Layer { size, shown: shown.collect(), data: true, raw: vec![("Z", view_depth)] }
}

/// Returns a layer of world-space normals, shown as colours.
pub fn normal(size: [u32; 2], surface: &SurfaceImage) -> Layer {
    let there: Vec<_> = surface.normal.iter().zip(&surface.view_depth).collect();
    let shown = there.iter().map(|(n, z)| if z.is_finite() { n.map(|c| 0.5 + 0.5 * c) } else { [0.0; 3] });
    let channel = |c: usize| there.iter().map(|(n, _)| n[c]).collect();
    let raw = vec![("N.X", channel(0)), ("N.Y", channel(1)), ("N.Z", channel(2))];
    Layer { size, shown: shown.collect(), data: true, raw }
}

/// Returns a layer of a picture tinted by `colors` according to each pixel's index, such as that of its
/// cascade. Pixels with an index below 0 keep their colour.
pub fn tinted(size: [u32; 2], rgba: &[u8], indices: Vec<f32>, colors: &[[f32; 3]]) -> Layer {
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
    /// Scales the layer down by `samples`: each pixel is the mean of `samples` × `samples` pixels. Raw values
    /// are dropped unless `samples` is 1.
    pub fn smaller(self, samples: u32) -> Self {
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

    /// Returns the picture for a PNG.
    pub fn picture(&self) -> Picture {
        let [width, height] = self.size;
        let encode =
            |c: f32| if self.data { (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8 } else { linear_to_srgb(c) };
        let rgb = self.shown.iter().flat_map(|p| p.map(encode)).collect();
        Picture { width, height, rgb, difference_share: None }
    }
}

/// Whether a path has the extension of OpenEXR files.
pub fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// Writes a layer: raw values as OpenEXR if the path ends in .exr, else a PNG.
///
/// # Errors
///
/// Returns an error if the file cannot be encoded or written.
pub fn write(path: &Path, layer: &Layer) -> Result<()> {
    if is_exr(path) {
        return write_exr(path, layer.size, &layer.raw);
    }
    Ok(write_png(path, &layer.picture())?)
}

/// Writes named channels of 32-bit floats as OpenEXR with lossless compression.
fn write_exr(path: &Path, size: [u32; 2], channels: &[(&str, Vec<f32>)]) -> Result<()> {
    use exr::prelude::*;
    let list = channels
        .iter()
        .map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.clone())))
        .collect();
    let image = Image::from_layer(Layer::new(
        (size[0] as usize, size[1] as usize),
        LayerAttributes::default(),
        Encoding::SMALL_FAST_LOSSLESS,
        AnyChannels::sort(list),
    ));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| Failure::BadInput(format!("{}: cannot encode the picture: {e}", path.display())))?;
    Ok(write_whole(path, bytes.get_ref())?)
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
