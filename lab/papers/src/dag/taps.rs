//! The taps of a filter, one block of 8 × 8 texels at a time. Leaf masks are fetched by cubes of eight
//! layers.
//!
//! A tap is answered by the voxel in its texel that the receiver's plane crosses there. The grid's x axis is
//! horizontal, so on level ground a row of taps is in one layer and is counted at once.

use crate::dag::LeafMasks;
use crate::dag::trail::Trail;
use adumbra::query::{FIXED_BITS, FixedReceiver, GRADIENT_BITS};

/// Depths of the receiver's plane at the taps of a block, in 2^-20 voxels.
struct Plane {
    /// Depth at the first tap.
    depth: i64,
    /// Change of depth from tap to tap along x and y.
    steps: [i64; 2],
}

impl Plane {
    fn over(r: &FixedReceiver, first_tap: [i64; 2]) -> Self {
        Self { depth: r.depth(first_tap), steps: r.gradient.map(|g| i64::from(g) << FIXED_BITS) }
    }
}

/// Cache of the most recently used cubes of 8 × 8 × 8 voxels. The slot is the cube's index along z modulo 8.
/// With 32 `PLACES` it also depends on the parity of the block.
pub(super) struct Cubes<'d, const PLACES: usize> {
    leaf_masks: &'d dyn LeafMasks,
    trail: Trail,
    kept: [Cube; PLACES],
}

/// A cached cube.
#[derive(Clone, Copy)]
struct Cube {
    /// Index of the cube, in cubes.
    place: [u32; 3],
    /// Leaf masks, nearest to the sun first: bit y·8 + x, 1 = lit.
    leaf_masks: [u64; 8],
    /// Bit z: leaf mask z is known.
    known: u8,
}

impl<'d, const PLACES: usize> Cubes<'d, PLACES> {
    pub(super) fn new(leaf_masks: &'d dyn LeafMasks) -> Self {
        let nowhere = Cube { place: [u32::MAX; 3], leaf_masks: [0; 8], known: 0 };
        Self { leaf_masks, trail: Trail::new(), kept: [nowhere; PLACES] }
    }

    /// Returns the number of lit taps of `filter` × `filter` texels around a receiver. Texels outside the
    /// grid and points before it are lit. Behind its last layer, the last layer is sampled.
    pub(super) fn lit_taps(&mut self, filter: u32, r: &FixedReceiver) -> u32 {
        let [nx, ny, nz] = self.leaf_masks.size().map(i64::from);
        let reach = i64::from(filter / 2);
        let texel = r.texel();
        let low = texel.map(|t| (t - reach).max(0));
        let high = [(texel[0] + reach).min(nx - 1), (texel[1] + reach).min(ny - 1)];
        if low[0] > high[0] || low[1] > high[1] {
            return filter * filter;
        }
        let inside = (high[0] - low[0] + 1) * (high[1] - low[1] + 1);
        let mut lit = filter * filter - inside as u32;
        let mut y = low[1];
        while y <= high[1] {
            let y_last = (y | 7).min(high[1]);
            let mut x = low[0];
            while x <= high[0] {
                let x_last = (x | 7).min(high[0]);
                let plane = Plane::over(r, [x, y]);
                lit += self.block(&plane, [x, x_last], [y, y_last], nz - 1);
                x = x_last + 1;
            }
            y = y_last + 1;
        }
        lit
    }

    /// Returns the number of lit taps among texels of one block, all inside the grid. The ranges are
    /// inclusive.
    fn block(&mut self, plane: &Plane, x: [i64; 2], y: [i64; 2], last_layer: i64) -> u32 {
        let [step_x, step_y] = plane.steps;
        let span = step_x * (x[1] - x[0]);
        // -1 for all layers before the grid.
        let layer_of = |depth: i64| (depth >> (FIXED_BITS + GRADIENT_BITS)).clamp(-1, last_layer);
        let mut bits_of = self.layers([x[0], y[0]]);
        let mut depth = plane.depth;
        let mut row = ((2 << (x[1] - x[0])) - 1) << (8 * (y[0] & 7) + (x[0] & 7));
        let mut lit: u64 = 0;
        for _ in y[0]..=y[1] {
            let [first, last] = [depth, depth + span].map(layer_of);
            if first == last {
                lit |= row & bits_of(first);
            } else {
                let (mut tap, mut at) = (row & row.wrapping_neg(), depth);
                for _ in x[0]..=x[1] {
                    lit |= tap & bits_of(layer_of(at));
                    (tap, at) = (tap << 1, at + step_x);
                }
            }
            (row, depth) = (row << 8, depth + step_y);
        }
        lit.count_ones()
    }

    /// Returns the leaf masks of a block by layer; all lit before the grid.
    fn layers(&mut self, [x, y]: [i64; 2]) -> impl FnMut(i64) -> u64 {
        let block = [x, y].map(|c| (c >> 3) as u32);
        move |layer| {
            if layer < 0 {
                return u64::MAX;
            }
            let place = [block[0], block[1], (layer >> 3) as u32];
            let slot = (place[2] & 7 | (place[0] & 1) << 3 | (place[1] & 1) << 4) as usize % PLACES;
            let cube = &mut self.kept[slot];
            if cube.place != place {
                (cube.place, cube.known) = (place, 0);
            }
            let z = (layer & 7) as usize;
            if cube.known >> z & 1 == 0 {
                let voxel = [place[0] << 3, place[1] << 3, layer as u32];
                cube.known |= self.leaf_masks.fill(&mut self.trail, voxel, &mut cube.leaf_masks);
            }
            cube.leaf_masks[z]
        }
    }
}
