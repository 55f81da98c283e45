//! Draws a tree's leaves from above, as squares coloured by size: Fig. 3-3 of the paper.

use adumbra_truth::picture::{Picture, encoded};

use crate::tree::VoxelTree;

/// Linear colours of leaves of 1, 2, 4 … voxels per side.
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
/// Factor that darkens a shadowed leaf.
const SHADOWED: f64 = 0.42;
/// Factor that darkens the rim of a leaf.
const RIM: f64 = 0.35;

/// Maximum side of the picture, pixels: 805 MB.
pub const MAX_NODES_SIDE: u32 = 1 << 14;

/// Draws the layer of voxels at height `y` of a tree, with x to the right and z down. Each voxel has `pixels`
/// pixels along each side: at least one, and at most as many as [`MAX_NODES_SIDE`] allows. If a tree has more
/// voxels per side than that, only every n-th voxel is drawn, with the smallest n that fits. Red is a single
/// voxel, then orange, yellow, green, blue to violet, each step twice as large; dark is shadowed. Leaves of
/// more than two pixels have a rim.
///
/// Cost: one look-up per pixel.
pub fn nodes_by_size(tree: &VoxelTree, y: u32, pixels: u32) -> Picture {
    let (pixels, step) = scale(tree.side(), pixels);
    let side = tree.side() / step * pixels;
    let mut rgb = Vec::with_capacity(side as usize * side as usize * 3);
    let y = y.min(tree.side() - 1);
    for row in 0..side {
        for column in 0..side {
            let (lit, level) = tree.find([column / pixels * step, y, row / pixels * step]);
            let color = LEVEL_COLORS[(level as usize).min(LEVEL_COLORS.len() - 1)];
            let leaf_pixels = ((pixels << level) / step).max(1);
            let on_rim = |c: u32| c.is_multiple_of(leaf_pixels);
            let rim = leaf_pixels > 2 && (on_rim(row) || on_rim(column));
            let shade = if lit { 1.0 } else { SHADOWED } * if rim { RIM } else { 1.0 };
            rgb.extend(encoded(color.map(|c| c * shade)));
        }
    }
    Picture { width: side, height: side, rgb, difference_share: None }
}

/// Pixels per voxel, and the step between drawn voxels, for a tree of `side` voxels; one of the two is 1.
fn scale(side: u32, pixels: u32) -> (u32, u32) {
    (pixels.clamp(1, (MAX_NODES_SIDE / side).max(1)), side.div_ceil(MAX_NODES_SIDE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::Word;

    #[test]
    fn nodes_picture_limits_its_side() {
        assert_eq!(scale(256, 3), (3, 1));
        assert_eq!(scale(256, 0), (1, 1));
        assert_eq!(scale(1 << 13, 3), (2, 1));
        assert_eq!(scale(1 << 14, u32::MAX), (1, 1));
        assert_eq!(scale(1 << 15, 3), (1, 2));
    }

    #[test]
    fn nodes_picture_shows_each_leaf_at_its_place() {
        // Depth 1: the children with z bit 1 are lit.
        let tree = VoxelTree::from_words(1, vec![Word::leaf(0b1010_1010).0]).unwrap();
        let picture = nodes_by_size(&tree, 0, 2);
        assert_eq!((picture.width, picture.height, picture.rgb.len()), (4, 4, 4 * 4 * 3));
        let red = |row: usize, column: usize| picture.rgb[(row * 4 + column) * 3];
        assert!(red(3, 0) > red(0, 0));
        assert_eq!((red(0, 0), red(3, 0)), (red(1, 3), red(2, 3)));
    }
}
