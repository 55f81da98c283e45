//! Leaves whose depths are on parallel planes: finds the gradient that needs the fewest planes.

use adumbra::layout::depths::slant::{SLANT_BITS, Slant};

use super::intervals::{ENDLESS, Intervals};

/// Returns candidate gradients: least-squares planes through the midpoints of intervals that have an end, once with
/// equal weights, and then with larger weights for narrower intervals, over all columns and over each quarter. Fits
/// that are flat or too steep are omitted.
pub(crate) fn candidates(intervals: &Intervals) -> impl Iterator<Item = Slant> + '_ {
    const QUARTERS: [u64; 4] = [0x0f0f_0f0f, 0xf0f0_f0f0, 0x0f0f_0f0f << 32, 0xf0f0_f0f0 << 32];
    let narrow = |width: f64| 1.0 / (1.0 + width * width);
    let all = [fit(intervals, u64::MAX, |_| 1.0), fit(intervals, u64::MAX, narrow)];
    all.into_iter().chain(QUARTERS.into_iter().map(move |columns| fit(intervals, columns, narrow))).flatten()
}

/// Fits a plane by least squares, with a weight from each interval's width. Sums are in a fixed order, so the result is
/// the same everywhere.
fn fit(intervals: &Intervals, columns: u64, weight: impl Fn(f64) -> f64) -> Option<Slant> {
    // Weighted sums of 1, x, y, x², xy, y², z, xz, yz.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::BlockColumns;

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
