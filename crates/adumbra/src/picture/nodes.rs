//! A tree's leaves from above, as coloured squares by size: the paper's Fig. 3-3.

use super::{Picture, srgb8};
use crate::tree::VoxelTree;

/// Linear colours of leaves of 1, 2, 4 … voxels a side.
const LEVEL_COLORS: [[f64; 3]; 10] = [
    [0.80, 0.08, 0.06],
    [0.90, 0.30, 0.04],
    [0.92, 0.62, 0.06],
    [0.45, 0.66, 0.09],
    [0.10, 0.52, 0.20],
    [0.06, 0.50, 0.52],
    [0.08, 0.28, 0.68],
    [0.22, 0.14, 0.62],
    [0.42, 0.12, 0.52],
    [0.30, 0.30, 0.34],
];
/// How much darker a shadowed leaf is.
const SHADOWED: f64 = 0.42;
/// How much darker the rim of a leaf is.
const RIM: f64 = 0.35;

/// The layer of voxels at height `y` of a tree, x to the right and z down, `pixels` a voxel along each side. Red = a
/// single voxel, then orange, yellow, green, blue to violet, twice as large at each step; dark = shadowed. Leaves of
/// more than two pixels have a rim.
///
/// Cost: one look-up a pixel.
pub fn nodes_by_size(tree: &VoxelTree, y: u32, pixels: u32) -> Picture {
    let side = tree.side() * pixels;
    let mut rgb = Vec::with_capacity((side * side) as usize * 3);
    let y = y.min(tree.side() - 1);
    for row in 0..side {
        for column in 0..side {
            let (lit, level) = tree.find([column / pixels, y, row / pixels]);
            let color = LEVEL_COLORS[(level as usize).min(LEVEL_COLORS.len() - 1)];
            let leaf_pixels = pixels << level;
            let on_rim = |c: u32| c.is_multiple_of(leaf_pixels);
            let rim = leaf_pixels > 2 && (on_rim(row) || on_rim(column));
            let shade = if lit { 1.0 } else { SHADOWED } * if rim { RIM } else { 1.0 };
            rgb.extend(color.map(|c| srgb8(c * shade)));
        }
    }
    Picture { width: side, height: side, rgb, difference_share: None }
}
