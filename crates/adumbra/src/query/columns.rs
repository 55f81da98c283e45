//! The taps of a filter, one block of 8 × 8 columns at a time, from the depths at which columns switch.
//!
//! A tap is lit where the receiver's plane crosses its column before the column's depth. A block whose
//! nearest depth is behind all of its taps is lit, and one whose farthest depth is before them is shadowed.
//! Only in between are columns compared, a row of eight at once.

use crate::layout::depths::TreeWords;
use crate::layout::depths::code::ColumnNode;
use crate::query::fixed::{FIXED_BITS, FIXED_ONE, FixedReceiver, GRADIENT_BITS, MAX_FIXED_SIDE};

/// Cached blocks. The slot is chosen by the parity of the block along both axes, because a filter of up to 9
/// texels touches at most two along each.
pub(super) struct Columns<'d> {
    tree: TreeWords<'d>,
    size: [i32; 3],
    kept: [Block; 4],
}

/// A cached block. Depths behind the grid's last layer are [`i32::MAX`], because nothing is sampled there.
#[derive(Clone, Copy)]
struct Block {
    /// Index of the block, in blocks.
    place: [i32; 2],
    /// Bounds of the columns' depths.
    nearest: i32,
    farthest: i32,
    /// The leaf from which `depths` still have to be read, if any.
    leaf: Option<[u32; 2]>,
    /// The columns' depths by row.
    depths: [[i32; 8]; 8],
}

impl<'d> Columns<'d> {
    /// Returns `None` for grids in which a filter's depths do not fit 32 bits.
    pub(super) fn new(tree: TreeWords<'d>) -> Option<Self> {
        if tree.size.iter().any(|side| *side > MAX_FIXED_SIDE) {
            return None;
        }
        let nowhere = Block { place: [-1; 2], nearest: 0, farthest: 0, leaf: None, depths: [[0; 8]; 8] };
        Some(Self { tree, size: tree.size.map(|side| side as i32), kept: [nowhere; 4] })
    }

    /// Returns the number of lit taps of `filter` × `filter` texels around a receiver. Texels outside the
    /// grid and points before it are lit. Behind its last layer, the last layer is sampled.
    pub(super) fn lit_taps(&mut self, filter: u32, r: &FixedReceiver) -> u32 {
        let reach = (filter / 2) as i32;
        let p = r.p_fixed.map(|c| c as i32);
        let texel = [p[0] >> FIXED_BITS, p[1] >> FIXED_BITS];
        let low = texel.map(|t| (t - reach).max(0));
        let high = [(texel[0] + reach).min(self.size[0] - 1), (texel[1] + reach).min(self.size[1] - 1)];
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
                lit += self.block(p, r.gradient, [x, x_last], [y, y_last]);
                x = x_last + 1;
            }
            y = y_last + 1;
        }
        lit
    }

    /// Returns the number of lit taps among columns of one block, all inside the grid. The ranges are
    /// inclusive.
    fn block(&mut self, p: [i32; 3], gradient: [i32; 2], x: [i32; 2], y: [i32; 2]) -> u32 {
        // For the taps, sums fit 32 bits, see the table of crate::query::fixed. For other columns of the
        // block, they may not.
        let from_center = |texel: i32, p: i32| ((texel << FIXED_BITS) + FIXED_ONE / 2).wrapping_sub(p);
        let along = |a: usize, texel: i32| gradient[a].wrapping_mul(from_center(texel, p[a]));
        let first = along(0, x[0]).wrapping_add(along(1, y[0]));
        let step = gradient.map(|g| g.wrapping_shl(FIXED_BITS));
        let last = self.size[2] - 1;
        let layer = |sum: i32| (p[2].wrapping_add(sum >> GRADIENT_BITS) >> FIXED_BITS).min(last);
        let spans = [step[0].wrapping_mul(x[1] - x[0]), step[1].wrapping_mul(y[1] - y[0])];
        let [nearest, farthest] = [i32::min, i32::max]
            .map(|end| layer(first.wrapping_add(end(spans[0], 0)).wrapping_add(end(spans[1], 0))));
        let taps = (x[1] - x[0] + 1) * (y[1] - y[0] + 1);

        let block = fetch(&mut self.kept, &self.tree, last, [x[0] >> 3, y[0] >> 3]);
        if farthest < block.nearest {
            return taps as u32;
        }
        if nearest >= block.farthest {
            return 0;
        }
        if let Some(leaf) = block.leaf.take() {
            block.read(&self.tree, leaf, last);
        }
        let row_start = first.wrapping_sub(step[0].wrapping_mul(x[0] & 7));
        let lanes: [i32; 8] =
            std::array::from_fn(|lane| row_start.wrapping_add(step[0].wrapping_mul(lane as i32)));
        let is_tap: [i32; 8] =
            std::array::from_fn(|lane| i32::from((x[0] & 7..=x[1] & 7).contains(&(lane as i32))));
        let mut lit = [0; 8];
        let mut down = 0;
        for row in &block.depths[(y[0] & 7) as usize..=(y[1] & 7) as usize] {
            for lane in 0..8 {
                let is_lit = layer(lanes[lane].wrapping_add(down)) < row[lane];
                lit[lane] += i32::from(is_lit) & is_tap[lane];
            }
            down = down.wrapping_add(step[1]);
        }
        lit.iter().sum::<i32>() as u32
    }
}

/// Returns the block at `place` of `kept`, with its bounds.
fn fetch<'k>(kept: &'k mut [Block; 4], tree: &TreeWords<'_>, last: i32, place: [i32; 2]) -> &'k mut Block {
    let block = &mut kept[(place[0] & 1 | (place[1] & 1) << 1) as usize];
    if block.place != place {
        let [i, j] = place.map(|c| (c as u32) << 3);
        let (bounds, leaf) = match tree.place(i, j).0 {
            ColumnNode::Uniform(value) => ([value; 2], None),
            ColumnNode::Leaf { at, base } => (tree.shapes().leaf(at, base).bounds(), Some([at, base])),
        };
        block.place = place;
        [block.nearest, block.farthest] = bounds.map(|depth| depth_in_grid(depth, last));
        block.leaf = leaf;
        if leaf.is_none() {
            block.depths = [[block.nearest; 8]; 8];
        }
    }
    block
}

impl Block {
    /// Reads the columns' depths.
    fn read(&mut self, tree: &TreeWords<'_>, [at, base]: [u32; 2], last: i32) {
        let depths = tree.shapes().leaf(at, base).values();
        for (to, depth) in self.depths.as_flattened_mut().iter_mut().zip(depths) {
            *to = depth_in_grid(depth, last);
        }
    }
}

fn depth_in_grid(depth: u32, last: i32) -> i32 {
    if depth > last as u32 { i32::MAX } else { depth as i32 }
}
