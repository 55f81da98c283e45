//! Where the columns of a small block switch from lit to shadowed: as few depths as their intervals allow, each on as round
//! a number as it may.
//!
//! Few depths make long curtains of one mask; round depths let neighbours, and levels above, agree. The fewest points that
//! hit every interval are those of the classic greedy choice: the smallest x left, and again.

use super::columns::FREE_TO_END;
use super::leaf::bits;
use super::sink::BlockColumns;

/// Depths beyond the last surface of a column whose end is free are rounded up to multiples of 2^this: the shadow still
/// begins close behind the surface, for what moves there.
pub(super) const FREE_ROUND_LEVEL: u32 = 6;

/// A depth, and the columns that switch there: bit y·8 + x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Switch {
    pub(super) depth: u32,
    pub(super) columns: u64,
}

/// Calls `visit` with the switches of a block, nearest first. Every column is in exactly one.
pub(super) fn for_each_switch(columns: &BlockColumns, mut visit: impl FnMut(Switch)) {
    let mut left = u64::MAX;
    while left != 0 {
        let end = bits(left).map(|i| columns.x[i]).min().unwrap_or(FREE_TO_END);
        let (mut here, mut start) = (0, 0);
        for i in bits(left) {
            if columns.e[i] <= end {
                here |= 1 << i;
                start = start.max(columns.e[i]);
            }
        }
        visit(Switch { depth: roundest(start, end), columns: here });
        left &= !here;
    }
}

/// The number of `[start, end]` that is a multiple of the highest power of two; where the end is free, a multiple of
/// 2^[`FREE_ROUND_LEVEL`].
pub(super) fn roundest(start: u32, end: u32) -> u32 {
    if end == FREE_TO_END {
        return start.checked_next_multiple_of(1 << FREE_ROUND_LEVEL).unwrap_or(start);
    }
    if start == 0 || start == end {
        return start;
    }
    // Below the highest bit in which start - 1 and end differ, end has only zeros to offer.
    let differ = 31 - ((start - 1) ^ end).leading_zeros();
    end & !((1 << differ) - 1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn roundest_is_the_number_with_most_zeros() {
        for start in 0..200_u32 {
            for end in start..200 {
                let best = (start..=end).max_by_key(|n| n.trailing_zeros()).unwrap_or(start);
                assert_eq!(roundest(start, end).trailing_zeros(), best.trailing_zeros(), "{start} {end}");
                assert!((start..=end).contains(&roundest(start, end)));
            }
        }
        assert_eq!(roundest(65, FREE_TO_END), 128);
        assert_eq!(roundest(64, FREE_TO_END), 64);
    }

    proptest! {
        #[test]
        fn switches_hit_every_interval_in_order(starts in prop::collection::vec((0_u32..300, 0_u32..90), 64)) {
            let mut columns = BlockColumns { e: [0; 64], x: [0; 64] };
            for (i, (e, length)) in starts.into_iter().enumerate() {
                columns.e[i] = e;
                columns.x[i] = if length > 80 { FREE_TO_END } else { e + length };
            }
            let (mut seen, mut last) = (0_u64, None);
            for_each_switch(&columns, |s| {
                assert_eq!(seen & s.columns, 0);
                seen |= s.columns;
                assert!(last.is_none_or(|l| l < s.depth));
                last = Some(s.depth);
                for i in bits(s.columns) {
                    assert!(columns.e[i] <= s.depth && s.depth <= columns.x[i]);
                }
            });
            prop_assert_eq!(seen, u64::MAX);
        }
    }
}
