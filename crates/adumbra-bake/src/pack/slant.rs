//! Leaves whose depths are on parallel planes: finds the gradient that needs the fewest planes.

use adumbra::layout::depths::slant::{SLANT_BITS, Slant};

use super::intervals::{COLUMNS, ENDLESS, Intervals};

/// Side of a quarter of a leaf, columns.
const QUARTER_SIDE: usize = 4;

/// Returns candidate gradients: least-squares planes through the midpoints of intervals that have an end,
/// once with equal weights, and then with larger weights for narrower intervals, over all columns and over
/// each quarter. Fits that are flat or too steep are omitted.
#[inline(always)]
pub(crate) fn candidates(intervals: &Intervals) -> impl Iterator<Item = Slant> {
    let samples = Samples::new(intervals);
    let equal = samples.quarters(&samples.counts);
    let narrow = samples.quarters(&samples.narrowness);
    let whole = [equal, narrow].map(|[a, b, c, d]| a.plus(&b).plus(&c.plus(&d)));
    whole.into_iter().chain(narrow).filter_map(|sums| sums.slant())
}

/// The midpoints of intervals, and their weights.
struct Samples {
    /// Twice the midpoint, relative to some interval's.
    z: [f64; COLUMNS],
    /// 1 for an interval that has an end, otherwise 0.
    counts: [f64; COLUMNS],
    /// A weight that is larger for narrower intervals, or 0 without an end.
    narrowness: [f64; COLUMNS],
}

impl Samples {
    #[inline(always)]
    fn new(intervals: &Intervals) -> Self {
        let [e, x] = [&intervals.e, &intervals.x];
        let reference = e.iter().zip(x).find(|(_, x)| **x != ENDLESS).map_or(0, |(e, x)| e + x);
        let mut samples = Self { z: [0.0; COLUMNS], counts: [0.0; COLUMNS], narrowness: [0.0; COLUMNS] };
        for i in 0..COLUMNS {
            let ends = x[i] != ENDLESS;
            let x = if ends { x[i] } else { e[i] };
            let width = f64::from(x - e[i]);
            let (z, narrowness) = (f64::from(e[i] + x - reference), 1.0 / (1.0 + width * width));
            samples.z[i] = if ends { z } else { 0.0 };
            samples.counts[i] = if ends { 1.0 } else { 0.0 };
            samples.narrowness[i] = if ends { narrowness } else { 0.0 };
        }
        samples
    }

    /// Returns the sums over each quarter, lower columns and then lower rows first.
    #[inline(always)]
    fn quarters(&self, weights: &[f64; COLUMNS]) -> [Sums; 4] {
        let mut quarters = [Sums([0.0; SUMS]); 4];
        for (quarter, sums) in quarters.iter_mut().enumerate() {
            let corner = [quarter & 1, quarter >> 1].map(|c| c * QUARTER_SIDE);
            // One lane per column, which are added in a fixed order.
            let mut lanes = [[0.0; QUARTER_SIDE]; SUMS];
            for row in 0..QUARTER_SIDE {
                for column in 0..QUARTER_SIDE {
                    let at = (corner[1] + row) * 2 * QUARTER_SIDE + corner[0] + column;
                    let [i, j] = [(corner[0] + column) as f64, (corner[1] + row) as f64];
                    let (w, z) = (weights[at], self.z[at]);
                    let terms = [1.0, i, j, i * i, i * j, j * j, z, i * z, j * z];
                    for (lanes, term) in lanes.iter_mut().zip(terms) {
                        lanes[column] += w * term;
                    }
                }
            }
            sums.0 = lanes.map(|[a, b, c, d]| (a + b) + (c + d));
        }
        quarters
    }
}

/// Number of [`Sums`].
const SUMS: usize = 9;

/// Weighted sums of 1, x, y, x², xy, y², z, xz, yz. They are added in a fixed order, so the result is the
/// same everywhere.
#[derive(Clone, Copy)]
struct Sums([f64; SUMS]);

impl Sums {
    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|n| self.0[n] + other.0[n]))
    }

    /// Returns the gradient of the least-squares plane, unless it is flat or too steep.
    #[inline(always)]
    fn slant(&self) -> Option<Slant> {
        let [w, i, j, ii, ij, jj, z, iz, jz] = self.0;
        // Central moments, times the square of the total weight.
        let [xx, xy, yy] = [w * ii - i * i, w * ij - i * j, w * jj - j * j];
        // z is twice the midpoint.
        let [xz, yz] = [w * iz - i * z, w * jz - j * z].map(|sum| 0.5 * sum);
        let determinant = xx * yy - xy * xy;
        let gradient = if determinant > 1e-6 * (xx + yy) * (xx + yy) {
            [(xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant]
        } else {
            // For columns along one line, only the slope along it is known.
            [xz / (xx + yy), yz / (xx + yy)]
        };
        let [x, y] = gradient.map(|g| (g * f64::from(1 << SLANT_BITS)).round());
        let fits = |g: f64| g.abs() <= 127.0;
        (fits(x) && fits(y) && (x != 0.0 || y != 0.0)).then_some(Slant { x: x as i8, y: y as i8 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::BlockColumns;

    #[test]
    fn slant_candidates_fit_the_columns_that_end() {
        let mut columns = BlockColumns::free();
        for at in (0..64).filter(|at| at % 3 != 0) {
            columns.e[at] = 100 + 2 * (at as u32 & 7) + (at as u32 >> 3) / 2;
            columns.x[at] = columns.e[at] + 1;
        }
        let found: Vec<_> = candidates(&Intervals::new(&columns)).collect();
        assert!(!found.is_empty() && found.iter().all(|slant| *slant == Slant { x: 8, y: 2 }), "{found:?}");
    }
}
