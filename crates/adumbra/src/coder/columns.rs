//! The rank of each column of a leaf.

use super::contour::{Leaf, class};
use super::rans::Coder;
use super::walk::Walk;
use crate::layout::depths::NEVER;

impl<C: Coder> Walk<'_, C> {
    /// Codes the ranks of a leaf's columns.
    pub(super) fn columns(&mut self, [x, y]: [usize; 2], base: u32, leaf: &mut Leaf) {
        if leaf.last == 0 {
            leaf.ranks = [0; 64];
            return;
        }
        let (mut ranks, sure) = self.facing_ranks([x, y], base, leaf);
        let known = [self.edges.above[x / 8], self.edges.left[y / 8]].map(|f| f.class != class::UNKNOWN);
        if !known[0] {
            let first = if known[1] { ranks[8] } else { ranks[0] };
            ranks[..8].fill(first);
        } else if !known[1] {
            let first = ranks[0];
            ranks[8..].fill(first);
        }
        self.rows(ranks, if known[0] { sure } else { 0 }, leaf);
    }

    /// Returns, for each column above and to the left, the rank with the nearest depth, and a mask of the
    /// columns above whose nearest depth is within 2.
    fn facing_ranks(&self, at: [usize; 2], base: u32, leaf: &Leaf) -> ([u8; 16], u32) {
        let cells = self.edges.facing_cells(at, leaf.slant);
        let ahead = cells.map(|cell| cell.wrapping_sub(base) as i32);
        let mut ranks = [0_u8; 16];
        let mut off = ahead;
        let mut depth = 0_i32;
        for &difference in &leaf.differences[..leaf.stored()] {
            let middle = depth.wrapping_add((difference / 2) as i32);
            depth = depth.wrapping_add(difference as i32);
            for i in 0..16 {
                let deeper = ahead[i] > middle;
                ranks[i] += u8::from(deeper);
                off[i] = if deeper { ahead[i].wrapping_sub(depth) } else { off[i] };
            }
        }
        let mut sure = 0;
        for i in 0..16 {
            let never = cells[i] == NEVER;
            ranks[i] = if never { leaf.last as u8 } else { ranks[i] };
            let is_sure = if never { leaf.never } else { off[i].wrapping_add(2) as u32 <= 4 };
            sure |= u32::from(is_sure) << i;
        }
        (ranks, sure & 0xff)
    }

    /// Codes rows of ranks, each as its changes from the row above. `facing` has row −1, then column −1.
    ///
    /// A row below a flat row begins with a bit: whether the two rows are equal. Otherwise, a symbol for each
    /// half of a row says which of its four columns changed. If a changed column has more than one possible
    /// new rank, a further code gives the rank.
    fn rows(&mut self, facing: [u8; 16], sure: u32, leaf: &mut Leaf) {
        let (mut coder, model) = (std::mem::take(&mut self.coder), &mut *self.model);
        let last = leaf.last as u8;
        let kind = usize::from(last > 1) + usize::from(last > 4);
        let (model_rows, still) = (&mut model.row[kind], &mut model.still[kind]);
        let values = &mut model.value[usize::from(last.max(2) - 2).min(2) + usize::from(last > 7)];
        // A row is eight bytes, of which the lowest is column 0.
        let mut row = u64::from_le_bytes(std::array::from_fn(|x| facing[x]));
        let mut corner = facing[0];
        let mut changed_above = 0;
        for y in 0..8 {
            let west = facing[8 + y];
            let goal = u64::from_le_bytes(std::array::from_fn(|x| leaf.ranks[8 * y + x]));
            let goal_changed = if C::DECODES { 0 } else { differing(goal, row) };
            // Bit x: columns x − 1 and x of the row above differ.
            let steps = differing(row, row << 8 | u64::from(corner));
            let flat = steps == 0 && west == corner;
            let (mut now, mut changed, mut w) = (row, 0, west);
            let bit = &mut still[y][usize::from(changed_above != 0)];
            let is_still = flat && coder.bit(bit, u32::from(goal_changed == 0)) == 1;
            for half in if is_still { 0..0 } else { 0..2 } {
                let first = 4 * half;
                let history = match y {
                    // The row above is flat, and this row differs from it.
                    _ if flat && changed == 0 => 18 + half as usize,
                    0 => 16 + usize::from(sure >> first & 15 == 15),
                    _ => (changed_above >> first & 15) as usize,
                };
                let same = usize::from(w == (row >> (8 * first)) as u8);
                let context = (steps >> first & 15) as usize + 16 * same + 32 * history;
                let columns = coder.symbol(&mut model_rows[context], goal_changed >> first & 15);
                changed |= columns << first;
                let mut left = columns << first;
                if last == 1 {
                    // The lowest bit of each column's byte.
                    now ^= u64::from(columns.wrapping_mul(0x0020_4081) & 0x0101_0101) << (8 * first);
                    left = 0;
                }
                while left != 0 {
                    let shift = 8 * left.trailing_zeros();
                    left &= left - 1;
                    let n = (row >> shift) as u8;
                    let w = if shift > 0 { (now >> (shift - 8)) as u8 } else { west };
                    let ne = if shift < 56 { (row >> (shift + 8)) as u8 } else { n };
                    let rank = (goal >> shift) as u8;
                    let rank = if last < 16 {
                        let about = if ne == w { 0 } else { 16 + 16 * usize::from(ne != n) };
                        let value = &mut values[usize::from(w.wrapping_sub(n) & 15) + about];
                        n.wrapping_add(coder.symbol(value, u32::from(rank.wrapping_sub(n) & 15)) as u8) & 15
                    } else {
                        coder.plain(6, rank.into()) as u8
                    };
                    now = now & !(0xff << shift) | u64::from(rank.min(last)) << shift;
                }
                w = (now >> (8 * first + 24)) as u8;
            }
            leaf.ranks[8 * y..8 * y + 8].copy_from_slice(&now.to_le_bytes());
            (changed_above, corner, row) = (changed, west, now);
        }
        self.coder = coder;
    }
}

/// Returns which of eight bytes differ. No byte is above 127.
#[inline(always)]
fn differing(a: u64, b: u64) -> u32 {
    let bits = ((a ^ b) + 0x7f7f_7f7f_7f7f_7f7f) >> 7 & 0x0101_0101_0101_0101;
    (bits.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u32
}
