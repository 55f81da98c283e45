//! Hybrid maps on the CPU: the build, identical to the GPU's word for word, and the look-up, comparing every
//! finest texel.

mod build;
mod leaf;
mod normals;
mod paper;

pub use paper::HybridPaper;

use adumbra_shaders::constants::{DEPTH_16_STEP, HYBRID_INDEX};
use adumbra_shaders::layout::HybridParams;

use super::MergeTest;
use super::settings::PlaneUnits;
use crate::error::{RenderError, Result};
use crate::maps::DepthPrecision;
use crate::maps::twin::{Receiver, Surface};
use leaf::leaf;

/// Light depth, a square of texels row by row: linear, 0 nearest the sun, 1 farthest or no caster.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthImage {
    side: usize,
    texels: Vec<f32>,
}

impl DepthImage {
    /// Validates `texels` and wraps them.
    ///
    /// # Errors
    /// Returns [`RenderError::DepthImage`] if `side` is not a power of two from 2 to 16,384, if the number of
    /// texels is not its square, or if a depth is NaN or outside 0 to 1.
    pub fn new(side: usize, texels: Vec<f32>) -> Result<Self> {
        let wrong = |what: String| RenderError::DepthImage { what };
        if !side.is_power_of_two() || !(2..=16384).contains(&side) {
            return Err(wrong(format!("a side of {side} texels is not a power of two from 2 to 16384")));
        }
        if texels.len() != side * side {
            return Err(wrong(format!("{} texels are not {side} x {side}", texels.len())));
        }
        if let Some(at) = texels.iter().position(|d| !(0.0..=1.0).contains(d)) {
            return Err(wrong(format!(
                "the depth {} at column {}, row {} is not between 0 and 1",
                texels[at],
                at % side,
                at / side
            )));
        }
        Ok(Self { side, texels })
    }

    /// Texels per side.
    pub fn side(&self) -> usize {
        self.side
    }

    /// All texels, row by row.
    pub fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// Applies the rounding of the shader's `start_at` for 16-bit maps to the whole image.
    fn rounded_to_16_bits(&self) -> Self {
        let texels = self.texels.iter().map(|d| (d.abs() * 65535.0 + 0.5).floor() * DEPTH_16_STEP).collect();
        Self { side: self.side, texels }
    }

    fn at(&self, x: usize, y: usize) -> f32 {
        // Matches the shader's abs(), which turns a depth of -0 into 0.
        self.texels[y * self.side + x].abs()
    }

    /// Depths of a block: top left, top right, bottom left, bottom right.
    fn block(&self, x: usize, y: usize) -> [f32; 4] {
        [0, 1, 2, 3].map(|i| self.at(2 * x + i % 2, 2 * y + i / 2))
    }
}

/// How a hybrid map merges texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MergeSettings {
    /// Number of levels above the finest.
    pub merges: u32,
    /// The merge test.
    pub test: MergeTest,
    /// Precision of the finest texels.
    pub precision: DepthPrecision,
    /// Units of merged planes.
    pub units: PlaneUnits,
}

/// A hybrid map in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct HybridTree {
    /// Finest resolution, texels per side.
    pub start: u32,
    /// How the map was merged.
    pub settings: MergeSettings,
    /// Blocks that did not merge, by level from 1.
    pub split: [u32; 3],
    /// The map as core/hybrid.wgsl reads it, in the layout of access/hybrid_compact.wgsl.
    pub words: Vec<u32>,
}

impl HybridTree {
    /// Builds a map with 1 to 3 merges. With 16-bit precision, depths are rounded to it first. Cost: one read
    /// of the image per level.
    ///
    /// # Errors
    /// Returns [`RenderError::DepthImage`] if `merges` is not 1 to 3 or the image is too small for it.
    pub fn build(image: &DepthImage, settings: MergeSettings) -> Result<Self> {
        merges_fit(image, settings.merges)?;
        Ok(build::tree(image, settings))
    }

    /// Returns the depth that the map holds at a finest texel's centre, and the level that holds it.
    /// Coordinates are clamped to the border.
    pub fn texel(&self, x: i64, y: i64) -> (f32, u32) {
        let [x, y] = [x, y].map(|c| c.clamp(0, i64::from(self.start) - 1) as usize);
        let mut level = self.settings.merges;
        let side = (self.start >> level) as usize;
        let mut word = self.words[(y >> level) * side + (x >> level)];
        while word & HYBRID_INDEX != 0 {
            level -= 1;
            let place = (word ^ HYBRID_INDEX) as usize;
            let [right, below] = [x >> level & 1, y >> level & 1];
            if level == 0 {
                return (self.finest(place, right, below), 0);
            }
            word = self.words[place + right + 2 * below];
        }
        (leaf_at(self.settings.test, word, self.settings.units.slope, level, [x, y]), level)
    }

    fn finest(&self, place: usize, right: usize, below: usize) -> f32 {
        match self.settings.precision {
            DepthPrecision::Bits32 => f32::from_bits(self.words[place + right + 2 * below]),
            DepthPrecision::Bits16 => (self.words[place + below] >> (16 * right) & 0xffff) as f32 / 65535.0,
        }
    }

    /// Share of the area that each level covers, the finest first. The shares sum to 1.
    pub fn shares(&self) -> [f64; 4] {
        level_shares(self.start, self.settings.merges, self.split)
    }
}

fn merges_fit(image: &DepthImage, merges: u32) -> Result<()> {
    if (1..=3).contains(&merges) && image.side() >> merges > 0 {
        return Ok(());
    }
    let what = format!("{merges} merges of {} texels per side; use 1 to 3", image.side());
    Err(RenderError::DepthImage { what })
}

/// Depth of a merged texel of `level` at the centre of a finest texel.
fn leaf_at(test: MergeTest, word: u32, slope: i32, level: u32, [x, y]: [usize; 2]) -> f32 {
    let [d, dx, dy] = leaf(test, word, slope);
    let size = (1_u32 << level) as f32;
    let offset = |c: usize| c as f32 + 0.5 - ((c >> level) as f32 + 0.5) * size;
    d + (dx * offset(x) + dy * offset(y))
}

/// Share of the area that each level covers, the finest first. `split` counts the blocks of each level that
/// did not merge.
pub fn level_shares(start: u32, merges: u32, split: [u32; 3]) -> [f64; 4] {
    let cells = f64::from(start).powi(2);
    let mut shares = [0.0; 4];
    for (level, share) in (0_u32..).zip(&mut shares).take(merges as usize + 1) {
        // Texels of this level that a descent visits, less those that lead further down.
        let seen = if level == merges {
            f64::from(start >> merges).powi(2)
        } else {
            4.0 * f64::from(split[level as usize])
        };
        let down = if level == 0 { 0 } else { split[level as usize - 1] };
        *share = (seen - f64::from(down)) * f64::from(1 << (2 * level)) / cells;
    }
    shares
}

/// The shadow look-up on the CPU.
pub struct HybridTwin<'a> {
    /// The shader's parameters.
    pub params: &'a HybridParams,
    /// The map.
    pub tree: &'a HybridTree,
}

impl HybridTwin<'_> {
    /// Visibility of the sun at a point, 1 = lit. Matches `adumbra_shadow_factor` of passes/hybrid_map.wgsl,
    /// but compares every finest texel.
    pub fn visibility(&self, s: &Surface) -> f32 {
        let (size, width) = (self.params.start_texels, self.params.filter_width);
        let Some(r) = self.receiver(s) else { return 1.0 };
        if width == 1 {
            let [x, y] = r.p_texels.map(|c| (c.floor() as i64).clamp(0, i64::from(size) - 1));
            let plane = r.plane_depth([x as f32 + 0.5, y as f32 + 0.5]);
            return f32::from(u8::from(plane <= self.tree.texel(x, y).0));
        }
        let half_side = 0.5 * (width as f32 - 1.0);
        let low = r.p_texels.map(|c| c - half_side);
        let high = r.p_texels.map(|c| c + half_side);
        let overlap = |left: f32, a: usize| ((left + 1.0).min(high[a]) - left.max(low[a])).clamp(0.0, 1.0);
        let inside = |c: f32| (0.0..size as f32).contains(&c);
        let mut lit = 0.0;
        for (dx, dy) in (0..width).flat_map(|dy| (0..width).map(move |dx| (dx, dy))) {
            let (x, y) = (low[0].floor() + dx as f32, low[1].floor() + dy as f32);
            let beside = !inside(x) || !inside(y);
            if beside || r.plane_depth([x + 0.5, y + 0.5]) <= self.tree.texel(x as i64, y as i64).0 {
                lit += overlap(x, 0) * overlap(y, 1);
            }
        }
        lit / (4.0 * half_side * half_side)
    }

    /// The level at which the look-up ends, 0 = finest. `None` outside the map.
    pub fn level(&self, s: &Surface) -> Option<u32> {
        let r = self.receiver(s)?;
        let [x, y] = r.p_texels.map(|c| c.floor() as i64);
        Some(self.tree.texel(x, y).1)
    }

    fn receiver(&self, s: &Surface) -> Option<Receiver> {
        let size = self.params.start_texels;
        let min_bias = self.params.min_bias_depth;
        let r = Receiver::new(&self.params.layer, size, &self.params.bias, min_bias, s);
        r.p_texels.iter().all(|c| (0.0..=size as f32).contains(c)).then_some(r)
    }
}

#[cfg(test)]
mod tests;
