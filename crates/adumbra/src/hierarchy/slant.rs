//! Leaves whose depths lie on parallel planes: the gradient that takes the fewest of them.

use super::leaf::{ENDLESS, Intervals};

/// Bits behind the point of a gradient.
pub(super) const SLANT_BITS: u32 = 2;

/// How the depths of a leaf change: quarters of a voxel a column along x and along y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Slant {
    pub(super) x: i8,
    pub(super) y: i8,
}

impl Slant {
    pub(super) fn from_half(half: u32) -> Self {
        Self { x: half as u8 as i8, y: (half >> 8) as u8 as i8 }
    }

    pub(super) fn to_half(self) -> u16 {
        u16::from(self.x as u8) | u16::from(self.y as u8) << 8
    }

    /// How much nearer than the deepest corner of its plane a column switches, in voxels, rounded up.
    pub(super) fn rise(self, column: u32) -> u32 {
        let along = |g: i8, at: u32| -i32::from(g) * (at as i32 - if g > 0 { 7 } else { 0 });
        let quarters = along(self.x, column & 7) + along(self.y, column >> 3);
        (quarters as u32 + (1 << SLANT_BITS) - 1) >> SLANT_BITS
    }

    /// The rise of each column.
    pub(super) fn rises(self) -> [i32; 64] {
        std::array::from_fn(|column| self.rise(column as u32) as i32)
    }

    /// The largest of all rises.
    pub(super) fn largest_rise(self) -> u32 {
        let quarters = 7 * (u32::from(self.x.unsigned_abs()) + u32::from(self.y.unsigned_abs()));
        (quarters + (1 << SLANT_BITS) - 1) >> SLANT_BITS
    }

    /// Columns that rise by less than this, which is at least 1: in every row those from the deepest on.
    pub(super) fn below(self, rise: u32) -> u64 {
        let [x, y] = [self.x, self.y].map(|g| i32::from(g.unsigned_abs()));
        // The most quarters that are below.
        let most = ((rise - 1).min(LARGEST_RISE) << SLANT_BITS) as i32;
        if x == 0 {
            // Whole rows, as over level ground.
            let rows = if y == 0 { 8 } else { (most / y + 1).min(8) };
            return if self.y > 0 { u64::MAX << (64 - 8 * rows) } else { u64::MAX >> (64 - 8 * rows) };
        }
        // One division for the eight quotients. `inverse` exceeds 2^20 / x by at most 1, so `left * inverse / 2^20` exceeds `left / x` by at
        // most `left / 2^20`. The floors are equal where that is less than 1 / x: left * x <= 7 * 128 * 128 < 2^20.
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

/// The most voxels that a column of any leaf rises by.
const LARGEST_RISE: u32 = (2 * 7 * 128) >> SLANT_BITS;

/// Bits behind the point of the reciprocal of a gradient.
const RECIPROCAL_BITS: u32 = 20;

/// Gradients that columns may have: planes by least squares through the middles of intervals that end, each counted alike, and the
/// narrower the more; none where they are flat or too steep.
pub(super) fn candidates(intervals: &Intervals) -> impl Iterator<Item = Slant> + '_ {
    const QUARTERS: [u64; 4] = [0x0f0f_0f0f, 0xf0f0_f0f0, 0x0f0f_0f0f << 32, 0xf0f0_f0f0 << 32];
    let narrow = |width: f64| 1.0 / (1.0 + width * width);
    let all = [fit(intervals, u64::MAX, |_| 1.0), fit(intervals, u64::MAX, narrow)];
    all.into_iter().chain(QUARTERS.into_iter().map(move |columns| fit(intervals, columns, narrow))).flatten()
}

/// Least squares with a weight for each interval's width. Sums are in a fixed order, so the same everywhere.
fn fit(intervals: &Intervals, columns: u64, weight: impl Fn(f64) -> f64) -> Option<Slant> {
    // Weight, x, y, x², xy, y², z, xz, yz: sums of products with the weight.
    let mut sums = [0.0; 9];
    let mut reference = None;
    for (at, (&e, &x)) in intervals
        .e
        .iter()
        .zip(&intervals.x)
        .enumerate()
        .filter(|(at, (_, x))| columns >> at & 1 == 1 && **x != ENDLESS)
    {
        let z = f64::from(e + x - *reference.get_or_insert(e + x));
        let (w, [i, j]) = (weight(f64::from(x - e)), [at & 7, at >> 3].map(|c| c as f64));
        let terms = [1.0, i, j, i * i, i * j, j * j, z, i * z, j * z];
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += w * term);
    }
    let [w, i, j, ii, ij, jj, z, iz, jz] = sums;
    // About the mean, times the weight's square.
    let [xx, xy, yy] = [w * ii - i * i, w * ij - i * j, w * jj - j * j];
    // z is twice the middle.
    let [xz, yz] = [w * iz - i * z, w * jz - j * z].map(|sum| 0.5 * sum);
    let determinant = xx * yy - xy * xy;
    let gradient = if determinant > 1e-6 * (xx + yy) * (xx + yy) {
        [(xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant]
    } else {
        // Along one line only the slope along it is known.
        [xz / (xx + yy), yz / (xx + yy)]
    };
    let [x, y] = gradient.map(|g| (g * f64::from(1 << SLANT_BITS)).round());
    let fits = |g: f64| g.abs() <= 127.0;
    (fits(x) && fits(y) && (x != 0.0 || y != 0.0)).then_some(Slant { x: x as i8, y: y as i8 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::sink::BlockColumns;

    #[test]
    fn slant_rises_from_the_deepest_corner() {
        let slant = Slant { x: 8, y: -4 };
        assert_eq!((slant.rise(7), slant.rise(0), slant.rise(63)), (0, 14, 7));
        assert_eq!((slant.rise(56), slant.largest_rise()), (21, 21));
        assert_eq!(Slant::from_half(slant.to_half().into()), slant);
        assert_eq!(slant.below(22), u64::MAX);
        assert_eq!(slant.below(1), 1 << 7);
        assert_eq!(Slant { x: -128, y: -128 }.largest_rise(), LARGEST_RISE);
    }

    #[test]
    fn slant_finds_the_columns_below_any_rise_for_every_gradient() {
        for half in 0..=u32::from(u16::MAX) {
            let slant = Slant::from_half(half);
            let largest = slant.largest_rise();
            let mut of_rise = [0_u64; LARGEST_RISE as usize + 1];
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

    #[test]
    fn slant_is_found_through_columns_that_end() {
        let mut columns = BlockColumns::free();
        for at in (0..64).filter(|at| at % 3 != 0) {
            columns.e[at] = 100 + 2 * (at as u32 & 7) + (at as u32 >> 3) / 2;
            columns.x[at] = columns.e[at] + 1;
        }
        let found: Vec<_> = candidates(&Intervals::new(&columns)).collect();
        assert_eq!(found, vec![Slant { x: 8, y: 2 }; found.len()]);
    }
}
