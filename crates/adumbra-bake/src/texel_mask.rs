//! Sets of texels of an 8 × 8 block, one bit per texel: row · 8 + column.

/// The texels for which `test` holds.
#[inline(always)]
pub(crate) fn texels_where(test: impl Fn(usize) -> bool) -> u64 {
    // First one byte per texel: compilers vectorize this, but not a loop that shifts single bits.
    let mut bytes = [0_u8; 64];
    for (texel, byte) in bytes.iter_mut().enumerate() {
        *byte = u8::from(test(texel));
    }
    let (rows, _) = bytes.as_chunks();
    let mut mask = 0;
    for &row in rows.iter().rev() {
        // The multiplication moves the low bit of byte c to bit c of the highest byte.
        mask = mask << 8 | u64::from_le_bytes(row).wrapping_mul(0x0102_0408_1020_4080) >> 56;
    }
    mask
}

/// Iterates over the texels of a set, in order.
#[inline(always)]
pub(crate) fn texels_of(mut mask: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (mask != 0).then(|| {
            let texel = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            texel
        })
    })
}

/// Returns the texels in the given columns and rows, both inclusive, clipped to the block.
#[inline(always)]
pub(crate) fn rectangle(columns: (i64, i64), rows: (i64, i64)) -> u64 {
    let cut = |(first, last): (i64, i64)| (first.max(0), last.min(7));
    let ((left, right), (top, bottom)) = (cut(columns), cut(rows));
    if left > right || top > bottom {
        return 0;
    }
    let row = (0xff << left) & (0xff >> (7 - right));
    (row * 0x0101_0101_0101_0101) & (u64::MAX << (8 * top)) & (u64::MAX >> (8 * (7 - bottom)))
}

/// Returns the texels where a linear function is at least 0: `first` at texel 0, plus `step_x` per column and
/// `step_y` per row.
#[inline(always)]
pub(crate) fn not_negative(first: i64, step_x: i64, step_y: i64) -> u64 {
    // Collects sign bits, one lane per column and one byte per row, so that compilers vectorize the loop.
    let mut values = [first; 8];
    for (column, value) in values.iter_mut().enumerate() {
        *value += column as i64 * step_x;
    }
    let mut negative = [0_u64; 8];
    for row in 0..8 {
        for (value, negative) in values.iter_mut().zip(&mut negative) {
            *negative |= (*value as u64 >> 63) << (8 * row);
            *value += step_y;
        }
    }
    let mut mask = 0;
    for (column, negative) in negative.iter().enumerate() {
        mask |= negative << column;
    }
    !mask
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn place(texel: usize) -> [i64; 2] {
        [texel as i64 % 8, texel as i64 / 8]
    }

    #[test]
    fn rectangle_is_clipped_to_the_block() {
        assert_eq!(rectangle((0, 7), (0, 7)), u64::MAX);
        assert_eq!(rectangle((-3, 1), (6, 90)), 0x0303_0000_0000_0000);
        assert_eq!(rectangle((2, 1), (0, 7)), 0);
        assert_eq!(rectangle((8, 9), (0, 7)), 0);
    }

    proptest! {
        #[test]
        fn masks_equal_sets_of_single_texels(
            first in -5_000_i64..5_000, step_x in -900_i64..900, step_y in -900_i64..900,
            columns in (-3_i64..10, -3_i64..10), rows in (-3_i64..10, -3_i64..10),
        ) {
            let value = |[x, y]: [i64; 2]| first + x * step_x + y * step_y;
            prop_assert_eq!(not_negative(first, step_x, step_y), texels_where(|t| value(place(t)) >= 0));
            let inside = |t| {
                let [x, y] = place(t);
                (columns.0..=columns.1).contains(&x) && (rows.0..=rows.1).contains(&y)
            };
            let mask = rectangle(columns, rows);
            prop_assert_eq!(mask, texels_where(inside));
            prop_assert_eq!(texels_of(mask).collect::<Vec<_>>(), (0..64).filter(|&t| inside(t)).collect::<Vec<_>>());
        }
    }
}
