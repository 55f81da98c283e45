//! Where a column enters and leaves solids.

use crate::triangles::depth::FixedDepth;

/// Offset in depth steps that makes a depth an unsigned key.
const KEY_OFFSET: i64 = 1 << 28;

/// Encodes a solid's crossing as a sortable word: depth plus 2^28 in bits 31..1; bit 0 = 1 if the ray leaves
/// the solid.
pub(crate) fn crossing_key(depth: FixedDepth, exit_bit: u32) -> u32 {
    ((i64::from(depth) + KEY_OFFSET) as u32) << 1 | exit_bit
}

/// Returns the depth of the first of the sorted crossings at which all solids that were entered have been
/// left. Returns `None` if there is no such crossing; then the column is open.
///
/// A self-intersecting hull may be left before it is entered. Its column ends right there, so a column always
/// ends where a solid is left.
pub(crate) fn solid_end(sorted: &[u32]) -> Option<FixedDepth> {
    let mut inside = 0_u32;
    for &key in sorted {
        if key & 1 == 0 {
            inside += 1;
        } else {
            inside = inside.saturating_sub(1);
            if inside == 0 {
                return Some((i64::from(key >> 1) - KEY_OFFSET) as FixedDepth);
            }
        }
    }
    None
}

/// Calls `visit(from, to)` for every interval of positive winding in sorted crossings; `to` is where the
/// winding is back at 0. Visits nothing if the count becomes negative; then the column is open. A solid that
/// is entered but never left has no interval.
pub(crate) fn for_each_inside(sorted: &[u32], mut visit: impl FnMut(FixedDepth, FixedDepth)) {
    let depth = |key: u32| (i64::from(key >> 1) - KEY_OFFSET) as FixedDepth;
    let step = |key: u32| if key & 1 == 0 { 1 } else { -1 };
    let mut winding = 0;
    for &key in sorted {
        winding += step(key);
        if winding < 0 {
            return;
        }
    }
    let (mut winding, mut from) = (0, 0);
    for &key in sorted {
        if winding == 0 {
            from = depth(key);
        }
        winding += step(key);
        if winding == 0 && depth(key) > from {
            visit(from, depth(key));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the intervals of crossings that are given as (depth, is left).
    fn insides(crossings: &[(FixedDepth, bool)]) -> Vec<(FixedDepth, FixedDepth)> {
        let mut keys: Vec<_> = crossings.iter().map(|&(d, left)| crossing_key(d, u32::from(left))).collect();
        keys.sort_unstable();
        let mut found = Vec::new();
        for_each_inside(&keys, |from, to| found.push((from, to)));
        found
    }

    #[test]
    fn columns_are_inside_solids_from_entry_to_exit() {
        let (enters, leaves) = (|d| (d, false), |d| (d, true));
        assert_eq!(insides(&[]), []);
        assert_eq!(insides(&[enters(-5), leaves(9)]), [(-5, 9)]);
        // Nested, and one behind the other.
        let nested = [enters(10), enters(20), leaves(30), leaves(40), enters(50), leaves(60)];
        assert_eq!(insides(&nested), [(10, 40), (50, 60)]);
        // Abutting: at equal depth entering sorts before leaving, so there is no gap.
        assert_eq!(insides(&[enters(1), leaves(5), enters(5), leaves(8)]), [(1, 8)]);
        // Zero thickness; never left; left before it is entered.
        assert_eq!(insides(&[enters(3), leaves(3)]), []);
        assert_eq!(insides(&[enters(1), leaves(2), enters(7)]), [(1, 2)]);
        assert_eq!(insides(&[leaves(0), enters(1), leaves(2)]), []);
    }
}
