//! Mip levels of a texture's colours, byte-identical for the CPU renderer and the GPU.
//!
//! Each level has half as many texels per side as the one before, rounded down. Each texel is the mean of the
//! texels it covers. A texel of an odd side covers two texels and part of a third, so that no row or column
//! is lost. Colours are averaged in linear light and weighted by alpha, so that cut-out texels do not bleed
//! into the others.

use std::borrow::Cow;

use crate::srgb::{linear_to_srgb, srgb_to_linear};
use crate::texture::{Grid, Pixels, Texture};

/// One mip level: four bytes per texel, sRGB red, green and blue, then linear alpha, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MipLevel {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// The texels.
    pub rgba: Vec<u8>,
}

impl Texture {
    /// All texels as RGBA; alpha-only texels are white.
    pub fn rgba(&self) -> Cow<'_, [u8]> {
        match &self.pixels {
            Pixels::Rgba(rgba) => Cow::Borrowed(rgba),
            Pixels::Alpha(alpha) => alpha.iter().flat_map(|&a| [255, 255, 255, a]).collect(),
        }
    }

    /// The mip levels below the texture itself, down to a single texel. Cost: about 20 ns per texel. Memory:
    /// a third of the texture's size.
    pub fn mip_levels(&self) -> Vec<MipLevel> {
        let more = |width: u32, height: u32| width.max(height) > 1;
        let first = more(self.width, self.height).then(|| half(&self.rgba(), [self.width, self.height]));
        let next = |level: &MipLevel| {
            more(level.width, level.height).then(|| half(&level.rgba, [level.width, level.height]))
        };
        std::iter::successors(first, next).collect()
    }
}

/// A texture with its mip levels, for sampling colours.
#[derive(Debug)]
pub struct MippedTexture<'t> {
    texture: &'t Texture,
    levels: Vec<MipLevel>,
}

impl<'t> MippedTexture<'t> {
    /// Builds the mip levels. An alpha-only texture gets none, since its colour is white. Cost: that of
    /// [`Texture::mip_levels`].
    pub fn new(texture: &'t Texture) -> Self {
        let levels = match texture.pixels {
            Pixels::Rgba(_) => texture.mip_levels(),
            Pixels::Alpha(_) => Vec::new(),
        };
        Self { texture, levels }
    }

    /// Memory for a texture's mip levels in addition to the texture itself, bytes: a third of its size.
    pub fn bytes_of(texture: &Texture) -> u64 {
        match &texture.pixels {
            Pixels::Rgba(rgba) => rgba.len() as u64 / 3,
            Pixels::Alpha(_) => 0,
        }
    }

    /// Linear red, green and blue at `uv`, interpolated between the two mip levels around `level`, where 0 is
    /// the texture itself. Levels out of range are clamped. Cost: eight texels, or two for a nearest texture.
    pub fn color(&self, uv: [f32; 2], level: f32) -> [f32; 3] {
        let Pixels::Rgba(first) = &self.texture.pixels else { return [1.0; 3] };
        let level = level.max(0.0).min(self.levels.len() as f32);
        let (low, weight) = (level as usize, level.fract());
        let near = self.level_color(uv, first, low);
        if weight == 0.0 {
            return near;
        }
        let far = self.level_color(uv, first, low + 1);
        std::array::from_fn(|c| near[c] + (far[c] - near[c]) * weight)
    }

    /// The mip level at which no texel is skipped. `differences` are the changes in texture coordinates to
    /// the next pixel along each of the two screen axes (OpenGL 4.6, section 8.14, isotropic).
    pub fn level(&self, differences: [[f64; 2]; 2]) -> f32 {
        let size = [self.texture.width, self.texture.height].map(f64::from);
        let squared = |d: [f64; 2]| (d[0] * size[0]).powi(2) + (d[1] * size[1]).powi(2);
        let longest = squared(differences[0]).max(squared(differences[1]));
        // The logarithm is exact at powers of two. Zero differences give -∞, which the maximum turns into
        // level 0.
        (0.5 * libm::log2(longest)).max(0.0) as f32
    }

    fn level_color(&self, uv: [f32; 2], first: &[u8], level: usize) -> [f32; 3] {
        let Texture { width, height, wrap, nearest, .. } = *self.texture;
        let (size, rgba) = match level.checked_sub(1).and_then(|l| self.levels.get(l)) {
            Some(level) => ([level.width, level.height], level.rgba.as_slice()),
            None => ([width, height], first),
        };
        Grid { size, wrap, nearest }.sample(uv, |texel| {
            let bytes = rgba.get(4 * texel..4 * texel + 3);
            std::array::from_fn(|c| srgb_to_linear(bytes.map_or(255, |b| b[c])))
        })
    }
}

/// Downsamples these texels to the next level.
fn half(texels: &[u8], [width, height]: [u32; 2]) -> MipLevel {
    let half_size = [(width / 2).max(1), (height / 2).max(1)];
    let mut rgba = Vec::with_capacity(half_size[0] as usize * half_size[1] as usize * 4);
    for y in 0..half_size[1] {
        let rows = under(y, height);
        for x in 0..half_size[0] {
            let (mut sum, mut plain) = ([0.0_f32; 4], [0.0_f32; 3]);
            for (row, row_share) in rows.into_iter().filter(|r| r.1 > 0.0) {
                for (column, column_share) in under(x, width).into_iter().filter(|c| c.1 > 0.0) {
                    let at = 4 * (row as usize * width as usize + column as usize);
                    let share = row_share * column_share;
                    let alpha = f32::from(texels[at + 3]) * share;
                    for c in 0..3 {
                        let linear = srgb_to_linear(texels[at + c]);
                        sum[c] += linear * alpha;
                        plain[c] += linear * share;
                    }
                    sum[3] += alpha;
                }
            }
            for c in 0..3 {
                rgba.push(linear_to_srgb(if sum[3] > 0.0 { sum[c] / sum[3] } else { plain[c] }));
            }
            rgba.push((sum[3] + 0.5) as u8);
        }
    }
    MipLevel { width: half_size[0], height: half_size[1], rgba }
}

/// The texels along one side that a texel of the next level covers, and their weights.
fn under(half: u32, side: u32) -> [(u32, f32); 3] {
    let (first, count) = (2 * half, (side / 2) as f32);
    match side {
        0 | 1 => [(0, 1.0), (0, 0.0), (0, 0.0)],
        _ if side.is_multiple_of(2) => [(first, 0.5), (first + 1, 0.5), (0, 0.0)],
        _ => {
            let i = half as f32;
            [(first, count - i), (first + 1, count), (first + 2, i + 1.0)].map(|(t, w)| (t, w / side as f32))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Wrap;

    fn texture(width: u32, height: u32, rgba: Vec<u8>) -> Texture {
        let pixels = Pixels::Rgba(rgba);
        Texture { name: "t".into(), width, height, pixels, wrap: [Wrap::Clamp; 2], nearest: false }
    }

    #[test]
    fn mip_colours_ignore_transparent_texels() {
        // One opaque red texel and three transparent green ones.
        let mut texels = [0, 255, 0, 0].repeat(4);
        texels[..4].copy_from_slice(&[255, 0, 0, 255]);
        let levels = texture(2, 2, texels).mip_levels();
        assert_eq!((levels.len(), levels[0].rgba.as_slice()), (1, [255, 0, 0, 64].as_slice()));
        assert_eq!(texture(1, 1, vec![7, 8, 9, 255]).mip_levels(), []);
        let all_cut = texture(2, 1, vec![0, 0, 0, 0, 255, 255, 255, 0]).mip_levels();
        assert_eq!(all_cut[0].rgba, [188, 188, 188, 0]);
    }

    #[test]
    fn mip_levels_keep_the_mean_of_odd_sides() {
        // A white row and column at the far end of a black image with odd sides: a fifth, a third.
        for (width, height) in [(5, 1), (1, 5), (5, 3), (7, 5)] {
            let white = |x: u32, y: u32| (width > 1 && x == width - 1) || (height > 1 && y == height - 1);
            let texels = (0..width * height).flat_map(|i| {
                let v = if white(i % width, i / width) { 255 } else { 0 };
                [v, v, v, 255]
            });
            let texture = texture(width, height, texels.collect());
            let mean = |rgba: &[u8]| {
                let all: f32 = rgba.chunks_exact(4).map(|t| srgb_to_linear(t[0])).sum();
                all / (rgba.len() / 4) as f32
            };
            let levels = texture.mip_levels();
            assert_eq!(levels.last().map(|l| [l.width, l.height]), Some([1, 1]));
            for level in &levels {
                let off = mean(&level.rgba) - mean(&texture.rgba());
                assert!(off.abs() < 0.01, "{width} x {height}: {level:?}");
            }
        }
    }

    #[test]
    fn color_is_valid_at_any_coordinate_and_level() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for nearest in [false, true] {
                let t = Texture { wrap: [wrap; 2], nearest, ..texture(3, 1, vec![128; 12]) };
                let mipped = MippedTexture::new(&t);
                for u in [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, f32::MIN, -1e-12, 1.0] {
                    for level in [0.0, 0.3, f32::NAN, f32::INFINITY] {
                        let grey = srgb_to_linear(128);
                        assert!(mipped.color([u, 0.3], level).iter().all(|c| (c - grey).abs() < 0.01));
                    }
                }
            }
        }
    }

    #[test]
    fn colours_blend_between_levels() {
        let t = texture(2, 2, [[255, 255, 255, 255], [0, 0, 0, 255], [0, 0, 0, 255], [255; 4]].concat());
        let mipped = MippedTexture::new(&t);
        let at = |level| mipped.color([0.25, 0.25], level)[0];
        assert_eq!((at(-3.0), at(0.0)), (1.0, 1.0));
        let coarse = at(1.0);
        assert!((coarse - 0.5).abs() < 0.01 && at(9.0) == coarse);
        assert!((at(0.5) - 0.5 * (1.0 + coarse)).abs() < 1e-6);
        assert_eq!(mipped.level([[0.5, 0.0], [0.0, 0.25]]), 0.0);
        assert_eq!(mipped.level([[2.0, 0.0], [0.0, 0.5]]), 2.0);
        assert_eq!(mipped.level([[0.0; 2]; 2]), 0.0);
    }
}
