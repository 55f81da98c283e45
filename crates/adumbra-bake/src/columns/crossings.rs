//! Where a column enters and leaves solids.

use crate::triangles::depth::FixedDepth;

/// Offset in depth steps that makes a depth an unsigned key.
const KEY_OFFSET: i64 = 1 << 28;

/// Encodes a solid's crossing as a sortable word: depth plus 2^28 in bits 31..1; bit 0 = 1 if the ray leaves
/// the solid.
pub(crate) fn crossing_key(depth: FixedDepth, exit_bit: u32) -> u32 {
    ((i64::from(depth) + KEY_OFFSET) as u32) << 1 | exit_bit
}

/// Returns the depth of a crossing, and whether the ray leaves the solid there.
#[inline]
pub fn crossing(key: u32) -> (FixedDepth, bool) {
    ((i64::from(key >> 1) - KEY_OFFSET) as FixedDepth, key & 1 == 1)
}

/// Returns the depth of the first of the sorted crossings at which all solids that were entered have been
/// left. Returns `None` if there is no such crossing; then the column is open.
///
/// A self-intersecting hull may be left before it is entered. Its column ends right there, so a column always
/// ends where a solid is left.
pub(crate) fn solid_end(sorted: &[u32]) -> Option<FixedDepth> {
    let mut inside = 0_u32;
    for &key in sorted {
        let (depth, leaves) = crossing(key);
        if leaves {
            inside = inside.saturating_sub(1);
            if inside == 0 {
                return Some(depth);
            }
        } else {
            inside += 1;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_sort_by_depth_and_entries_before_exits() {
        let crossings = [(-5, false), (9, false), (9, true), (10, false)];
        let keys = crossings.map(|(depth, leaves)| crossing_key(depth, u32::from(leaves)));
        assert!(keys.is_sorted());
        assert_eq!(keys.map(crossing), crossings);
    }
}
