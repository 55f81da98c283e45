//! Builds the map on the CPU. Twin of passes/hybrid_merge_*.wgsl, hybrid_scan.wgsl and hybrid_place.wgsl,
//! word for word.

use adumbra_shaders::constants::{
    HYBRID_DEPTH_STEP, HYBRID_E0, HYBRID_INDEX, HYBRID_LAST_DEPTH, HYBRID_LAST_SLOPE, HYBRID_ONE,
    HYBRID_SLOPE_BITS,
};

use super::leaf::{middle, slope};
use super::{DepthImage, HybridTree, MergeSettings};
use crate::hybrid::MergeTest;
use crate::hybrid::settings::PlaneUnits;
use crate::maps::DepthPrecision;

/// One level, with one word per texel.
struct Level {
    side: usize,
    words: Vec<u32>,
}

impl Level {
    /// Words of a block: top left, top right, bottom left, bottom right.
    fn children(&self, x: usize, y: usize) -> [u32; 4] {
        [0, 1, 2, 3].map(|i| self.words[(2 * y + i / 2) * self.side + 2 * x + i % 2])
    }
}

pub(super) fn tree(image: &DepthImage, settings: MergeSettings) -> HybridTree {
    let MergeSettings { merges, test, precision, units } = settings;
    let rounded;
    let image = if precision == DepthPrecision::Bits16 {
        rounded = image.rounded_to_16_bits();
        &rounded
    } else {
        image
    };
    let side = image.side() >> merges;
    let mut map = vec![0; side * side];
    let mut split = [0; 3];
    let mut before: Option<Level> = None;
    for made in 1..=merges {
        let side = image.side() >> made;
        map.resize(map.len().next_multiple_of(4), 0);
        let mut words = Vec::with_capacity(side * side);
        for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
            let children = before.as_ref().map(|level| level.children(x, y));
            let merged = match test {
                MergeTest::Paper => mean(image, children, x, y),
                MergeTest::Plane { .. } => plane(image, children, made, units, x, y),
            };
            words.push(merged.unwrap_or_else(|| {
                split[made as usize - 1] += 1;
                let place = map.len() as u32;
                match (children, precision) {
                    (Some(words), _) => map.extend(words),
                    (None, DepthPrecision::Bits32) => map.extend(image.block(x, y).map(f32::to_bits)),
                    (None, DepthPrecision::Bits16) => {
                        let [a, b, c, d] = image.block(x, y).map(|d| (d * 65535.0 + 0.5) as u32);
                        map.extend([a | b << 16, c | d << 16]);
                    }
                }
                HYBRID_INDEX | place
            }));
        }
        before = Some(Level { side, words });
    }
    if let Some(coarsest) = before {
        map[..side * side].copy_from_slice(&coarsest.words);
    }
    HybridTree { start: image.side() as u32, settings, split, words: map }
}

/// Twin of WGSL `block_merged` for the paper's test.
fn mean(image: &DepthImage, children: Option<[u32; 4]>, x: usize, y: usize) -> Option<u32> {
    let depths = match children {
        None => image.block(x, y),
        Some(words) if words.iter().any(|w| w & HYBRID_INDEX != 0) => return None,
        Some(words) => words.map(f32::from_bits),
    };
    let mean = 0.25 * (((depths[0] + depths[1]) + depths[2]) + depths[3]);
    depths.iter().all(|&d| (mean - d).abs() <= HYBRID_E0 * d).then(|| mean.to_bits())
}

/// Twin of WGSL `block_merged` for planes.
fn plane(
    image: &DepthImage,
    children: Option<[u32; 4]>,
    made: u32,
    units: PlaneUnits,
    x: usize,
    y: usize,
) -> Option<u32> {
    let d = match children {
        None => image.block(x, y).map(steps),
        Some(words) if words.iter().any(|w| w & HYBRID_INDEX != 0) => return None,
        Some(words) => words.map(middle),
    };
    let apart = 1_i32 << made;
    let codes = [(d[1] + d[3]) - (d[0] + d[2]), (d[2] + d[3]) - (d[0] + d[1])]
        .map(|difference| slope_code(difference / apart, units.slope));
    let [along_x, along_y] = codes.map(|c| slope(c, units.slope));
    let (mut nearest, mut farthest) = (i32::MAX, -i32::MAX);
    for (j, i) in (0..apart).flat_map(|j| (0..apart).map(move |i| (j, i))) {
        let side = apart as usize;
        let depth = steps(image.at(x * side + i as usize, y * side + j as usize));
        let asked = 2 * depth - along_x * (2 * i + 1 - apart) - along_y * (2 * j + 1 - apart);
        nearest = nearest.min(asked);
        farthest = farthest.max(asked);
    }
    let code = ((farthest + 2 * HYBRID_DEPTH_STEP - 1) / (2 * HYBRID_DEPTH_STEP) - 1).max(0);
    let depth = (code + 1) * HYBRID_DEPTH_STEP;
    if code > HYBRID_LAST_DEPTH || 2 * depth - nearest > units.tolerance {
        return None;
    }
    Some((code as u32) << 14 | (codes[1] as u32 & 127) << 7 | codes[0] as u32 & 127)
}

/// Twin of WGSL `start_steps`.
fn steps(depth: f32) -> i32 {
    (depth * HYBRID_ONE).ceil() as i32
}

/// Twin of WGSL `slope_code`.
fn slope_code(wanted: i32, unit: i32) -> i32 {
    let size = wanted.abs();
    let about =
        ((size as f32 * (1 << HYBRID_SLOPE_BITS) as f32 / unit as f32).sqrt() as i32).min(HYBRID_LAST_SLOPE);
    let (mut best, mut best_off) = (0, size);
    for q in (about - 1).max(1)..=(about + 1).min(HYBRID_LAST_SLOPE) {
        let off = (slope(q, unit) - size).abs();
        if off < best_off {
            (best, best_off) = (q, off);
        }
    }
    if wanted < 0 { -best } else { best }
}
