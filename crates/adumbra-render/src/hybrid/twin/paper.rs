//! The paper's layout: texels of 128 bits and the list of links. Twin of passes/hybrid_place_paper.wgsl and
//! access/hybrid_paper.wgsl.

use adumbra_shaders::constants::{HYBRID_INDEX, HYBRID_NO_LINK, HYBRID_ONE};

use super::leaf::leaf;
use super::{DepthImage, HybridTree, MergeSettings, build, leaf_at, merges_fit, normals};
use crate::error::{RenderError, Result};
use crate::maps::DepthPrecision;

/// A hybrid map of the paper's layout in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct HybridPaper {
    /// Finest resolution, texels per side.
    pub start: u32,
    /// How the map was merged.
    pub settings: MergeSettings,
    /// Blocks that did not merge, by level from 1.
    pub split: [u32; 3],
    /// Channels R, G, B and A of each texel, as in access/hybrid_paper.wgsl.
    pub texels: Vec<[u32; 4]>,
    /// Links, each with the index of a texel and the index of the next link.
    pub links: Vec<[u32; 2]>,
}

/// Offsets of the blocks' children in a compact map, by the block's level from 1.
struct Blocks {
    /// Words that the children of one block take.
    width: [u32; 3],
    /// Offset of the first child of the level.
    begin: [u32; 3],
    /// Number of blocks of all previous levels.
    before: [u32; 3],
    /// Total number of words.
    words: u32,
}

impl Blocks {
    fn new(start: u32, settings: MergeSettings, split: [u32; 3]) -> Self {
        let MergeSettings { merges, precision, .. } = settings;
        let mut words = (start >> merges).pow(2);
        let mut blocks = 0;
        let mut all = Self { width: [4; 3], begin: [0; 3], before: [0; 3], words };
        if precision == DepthPrecision::Bits16 {
            all.width[0] = 2;
        }
        for (k, &count) in split.iter().enumerate().take(merges as usize) {
            all.begin[k] = words.next_multiple_of(4);
            all.before[k] = blocks;
            words = all.begin[k] + count * all.width[k];
            blocks += count;
        }
        all.words = words;
        all
    }

    /// Index of the first link in the list of a block, from the offset of its children.
    fn link(&self, level: u32, place: u32) -> u32 {
        let k = level as usize - 1;
        4 * (self.before[k] + (place - self.begin[k]) / self.width[k])
    }

    /// Offset of a block's children, the inverse of [`Blocks::link`].
    fn place(&self, level: u32, link: u32) -> u32 {
        let k = level as usize - 1;
        self.begin[k] + (link / 4 - self.before[k]) * self.width[k]
    }
}

/// The data that texels are filled from.
struct Source {
    tree: HybridTree,
    blocks: Blocks,
    /// Packed normals by level, row by row.
    normals: Vec<Vec<[u8; 2]>>,
}

impl HybridPaper {
    /// Builds a map with 1 to 3 merges from depth and one packed normal per texel. Cost: one read of the
    /// image per level.
    ///
    /// # Errors
    /// Returns [`RenderError::DepthImage`] if `merges` is not 1 to 3, if the image is too small for it, or if
    /// the number of normals is not the number of texels.
    pub fn build(image: &DepthImage, normals: &[[u8; 2]], settings: MergeSettings) -> Result<Self> {
        let merges = settings.merges;
        merges_fit(image, merges)?;
        if normals.len() != image.texels().len() {
            let what = format!("{} normals for {} texels", normals.len(), image.texels().len());
            return Err(RenderError::DepthImage { what });
        }
        let tree = build::tree(image, settings);
        let mut levels = vec![normals.to_vec()];
        for made in 1..=merges as usize {
            let side = image.side() >> made;
            let before = &levels[made - 1];
            let child = |x: usize, y: usize, i: usize| before[(2 * y + i / 2) * 2 * side + 2 * x + i % 2];
            let means = (0..side * side)
                .map(|at| normals::mean([0, 1, 2, 3].map(|i| child(at % side, at / side, i))));
            let means = means.collect();
            levels.push(means);
        }
        let blocks = Blocks::new(tree.start, settings, tree.split);
        let listed = 4 * tree.split.iter().sum::<u32>() as usize;
        let side = tree.start >> merges;
        let mut paper = Self {
            start: tree.start,
            settings,
            split: tree.split,
            texels: vec![[0; 4]; first_listed(tree.start, merges) as usize + listed],
            links: vec![[0; 2]; listed],
        };
        let source = Source { tree, blocks, normals: levels };
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let word = source.tree.words[(y * side + x) as usize];
            paper.fill(&source, y * side + x, merges, [x, y], word);
        }
        Ok(paper)
    }

    /// Writes a texel of level 1 or coarser and all texels below it.
    fn fill(&mut self, source: &Source, number: u32, level: u32, [x, y]: [u32; 2], word: u32) {
        if word & HYBRID_INDEX == 0 {
            let [depth, ..] = leaf(self.settings.test, word, self.settings.units.slope);
            self.texels[number as usize] =
                [x | y << 16, word, 0, packed(unorm16(depth), source.normal(level, [x, y]))];
            return;
        }
        let place = word ^ HYBRID_INDEX;
        let first = source.blocks.link(level, place);
        self.texels[number as usize] = [x | y << 16, 0, HYBRID_INDEX | first, 0];
        for i in 0..4 {
            let [right, below] = [i % 2, i / 2];
            let at = [2 * x + right, 2 * y + below];
            let child = first_listed(self.start, self.settings.merges) + first + i;
            let next = if i < 3 { first + i + 1 } else { HYBRID_NO_LINK };
            self.links[(first + i) as usize] = [child, next];
            if level > 1 {
                self.fill(source, child, level - 1, at, source.tree.words[(place + i) as usize]);
                continue;
            }
            let depth = source.tree.finest(place as usize, right as usize, below as usize);
            let short = unorm16(depth);
            let stored =
                if self.settings.precision == DepthPrecision::Bits16 { short } else { depth.to_bits() };
            let normal = source.normal(0, at);
            self.texels[child as usize] = [at[0] | at[1] << 16, stored, 0, packed(short, normal)];
        }
    }

    /// Returns the texel that holds a finest texel's depth, and its level. Follows each list, from the
    /// coarsest level down, to the texel with the wanted coordinates. Coordinates are clamped to the border.
    pub fn found(&self, x: i64, y: i64) -> ([u32; 4], u32) {
        let [x, y] = [x, y].map(|c| c.clamp(0, i64::from(self.start) - 1) as u32);
        let mut level = self.settings.merges;
        let mut texel = self.texels[((y >> level) * (self.start >> level) + (x >> level)) as usize];
        while texel[2] & HYBRID_INDEX != 0 {
            level -= 1;
            let wanted = (x >> level) | (y >> level) << 16;
            let mut link = texel[2] ^ HYBRID_INDEX;
            texel = [0; 4];
            while link != HYBRID_NO_LINK {
                let [number, next] = self.links[link as usize];
                texel = self.texels[number as usize];
                if texel[0] == wanted {
                    break;
                }
                link = next;
            }
        }
        (texel, level)
    }

    /// Returns the same as [`HybridTree::texel`].
    pub fn texel(&self, x: i64, y: i64) -> (f32, u32) {
        let (texel, level) = self.found(x, y);
        let depth = match (level, self.settings.precision) {
            (0, DepthPrecision::Bits32) => f32::from_bits(texel[1]),
            (0, DepthPrecision::Bits16) => texel[1] as f32 / 65535.0,
            _ => {
                let [x, y] = [x, y].map(|c| c.clamp(0, i64::from(self.start) - 1) as usize);
                leaf_at(self.settings.test, texel[1], self.settings.units.slope, level, [x, y])
            }
        };
        (depth, level)
    }

    /// Converts the map to the compact layout, without normals.
    pub fn compact(&self) -> HybridTree {
        let blocks = Blocks::new(self.start, self.settings, self.split);
        let mut words = vec![0; blocks.words as usize];
        for cell in 0..(self.start >> self.settings.merges).pow(2) {
            words[cell as usize] = self.word(&blocks, &mut words, cell, self.settings.merges);
        }
        HybridTree { start: self.start, settings: self.settings, split: self.split, words }
    }

    /// Returns a texel's compact word, and writes those of the texels below it to their offsets.
    fn word(&self, blocks: &Blocks, words: &mut [u32], number: u32, level: u32) -> u32 {
        let [_, depth, index, _] = self.texels[number as usize];
        if index & HYBRID_INDEX == 0 {
            return depth;
        }
        let mut link = index ^ HYBRID_INDEX;
        let place = blocks.place(level, link);
        while link != HYBRID_NO_LINK {
            let [child, next] = self.links[link as usize];
            let [right, below] =
                [self.texels[child as usize][0] & 1, self.texels[child as usize][0] >> 16 & 1];
            let word = self.word(blocks, words, child, level - 1);
            if level == 1 && self.settings.precision == DepthPrecision::Bits16 {
                words[(place + below) as usize] |= word << (16 * right);
            } else {
                words[(place + right + 2 * below) as usize] = word;
            }
            link = next;
        }
        HYBRID_INDEX | place
    }
}

impl Source {
    fn normal(&self, level: u32, [x, y]: [u32; 2]) -> [u8; 2] {
        let side = self.tree.start >> level;
        self.normals[level as usize][(y * side + x) as usize]
    }
}

/// Index of the first texel that a link leads to.
fn first_listed(start: u32, merges: u32) -> u32 {
    (start >> merges).pow(2).next_multiple_of(4)
}

/// Twin of WGSL `depth_unorm16`.
fn unorm16(depth: f32) -> u32 {
    let steps = (depth * HYBRID_ONE) as i32;
    ((steps + (((0.5 * HYBRID_ONE) as i32 - steps) >> 16)) >> 8) as u32
}

fn packed(depth: u32, [x, y]: [u8; 2]) -> u32 {
    depth << 16 | u32::from(y) << 8 | u32::from(x)
}

#[cfg(test)]
mod tests;
