//! The gradient of a leaf whose depths are on parallel planes.

/// Number of fraction bits of a gradient.
pub const SLANT_BITS: u32 = 2;

/// Gradient of a leaf's depths along x and y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Slant {
    /// Quarters of a voxel per column along x.
    pub x: i8,
    /// Quarters of a voxel per column along y.
    pub y: i8,
}

impl Slant {
    /// Decodes the second half-word of a slanted leaf.
    #[inline(always)]
    pub(crate) fn from_half(half: u32) -> Self {
        Self { x: half as u8 as i8, y: (half >> 8) as u8 as i8 }
    }

    /// Encodes the second half-word of a slanted leaf.
    pub fn to_half(self) -> u16 {
        u16::from(self.x as u8) | u16::from(self.y as u8) << 8
    }

    /// Returns by how much a column switches nearer to the sun than the deepest corner of its plane, in
    /// voxels, rounded up.
    #[inline(always)]
    pub fn rise(self, column: u32) -> u32 {
        (self.quarters((column & 7) as i32, (column >> 3) as i32) >> SLANT_BITS) as u32
    }

    /// Returns 3 more than four times the rise of a column, so that a shift by [`SLANT_BITS`] rounds it up.
    /// The column may be in a neighbouring leaf, where the plane may be behind its deepest corner.
    #[inline(always)]
    pub(crate) fn quarters(self, x: i32, y: i32) -> i32 {
        let along = |g: i8, at: i32| i32::from(g) * (at - if g > 0 { 7 } else { 0 });
        (1 << SLANT_BITS) - 1 - along(self.x, x) - along(self.y, y)
    }

    /// Returns the rise of each column, in voxels.
    #[inline(always)]
    pub fn rises(self) -> [i32; 64] {
        let mut rises = [0; 64];
        for (column, rise) in (0..).zip(&mut rises) {
            *rise = self.rise(column) as i32;
        }
        rises
    }

    /// Returns the largest rise of all columns, in voxels.
    pub(crate) fn largest_rise(self) -> u32 {
        let quarters = 7 * (u32::from(self.x.unsigned_abs()) + u32::from(self.y.unsigned_abs()));
        (quarters + (1 << SLANT_BITS) - 1) >> SLANT_BITS
    }

    /// Returns the columns that rise by less than `rise`, which must be at least 1. In every row they begin
    /// at the deepest column.
    pub fn below(self, rise: u32) -> u64 {
        let [x, y] = [self.x, self.y].map(|g| i32::from(g.unsigned_abs()));
        // The largest rise that is below the limit, in quarters.
        let most = ((rise - 1).min(MAX_RISE) << SLANT_BITS) as i32;
        if x == 0 {
            // Whole rows, as over level ground.
            let rows = if y == 0 { 8 } else { (most / y + 1).min(8) };
            return if self.y > 0 { u64::MAX << (64 - 8 * rows) } else { u64::MAX >> (64 - 8 * rows) };
        }
        // One division instead of eight. `inverse` exceeds 2^20 / x by at most 1, so `left * inverse /
        // 2^20` exceeds `left / x` by at most `left / 2^20`. The floors are equal if that is less than 1 / x,
        // which holds because left * x <= 7 * 128 * 128 < 2^20.
        let inverse = (1 << RECIPROCAL_BITS) / x + 1;
        (0..8).fold(0, |mask, row| {
            let left = most - y * if self.y > 0 { 7 - row } else { row };
            let columns = match left {
                ..0 => 0,
                _ => ((left.min(7 * x) * inverse) >> RECIPROCAL_BITS) + 1,
            };
            let bits = if self.x > 0 { 0xff << (8 - columns) & 0xff } else { (1 << columns) - 1 };
            mask | u64::from(bits as u8) << (8 * row)
        })
    }
}

/// Largest rise of a column of any leaf, in voxels.
const MAX_RISE: u32 = (2 * 7 * 128) >> SLANT_BITS;

/// Number of fraction bits of the reciprocal of a gradient.
const RECIPROCAL_BITS: u32 = 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slant_rises_from_the_deepest_corner() {
        let slant = Slant { x: 8, y: -4 };
        assert_eq!((slant.rise(7), slant.rise(0), slant.rise(63)), (0, 14, 7));
        assert_eq!((slant.rise(56), slant.largest_rise()), (21, 21));
        assert_eq!(Slant::from_half(slant.to_half().into()), slant);
        assert_eq!(slant.below(22), u64::MAX);
        assert_eq!(slant.below(1), 1 << 7);
        assert_eq!(Slant { x: -128, y: -128 }.largest_rise(), MAX_RISE);
    }

    #[test]
    fn slant_finds_the_columns_below_any_rise_for_every_gradient() {
        for half in 0..=u32::from(u16::MAX) {
            let slant = Slant::from_half(half);
            let largest = slant.largest_rise();
            let mut of_rise = [0_u64; MAX_RISE as usize + 1];
            (0..64).for_each(|column| of_rise[slant.rise(column) as usize] |= 1 << column);
            assert!(of_rise[0] != 0 && of_rise[largest as usize] != 0, "{slant:?}");
            let mut below = 0;
            for rise in 1..=largest + 1 {
                below |= of_rise[rise as usize - 1];
                assert_eq!(slant.below(rise), below, "{slant:?} {rise}");
            }
            assert_eq!([slant.below(u32::MAX), below], [u64::MAX; 2], "{slant:?}");
        }
    }
}
