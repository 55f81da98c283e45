//! The intervals of a leaf's columns, as signed integers that a slant can shift.

use adumbra::layout::depths::slant::Slant;

use crate::columns::BlockColumns;
use crate::columns::rules::FREE_TO_END;

/// Number of columns of a leaf.
pub(crate) const COLUMNS: usize = 64;

/// Intervals of 64 columns, shifted by a slant's rise.
pub(crate) struct Intervals {
    pub(crate) e: [i32; COLUMNS],
    /// [`ENDLESS`] if the interval has no end.
    pub(crate) x: [i32; COLUMNS],
    pub(crate) slant: Slant,
}

/// The x of a column that must not switch.
pub(crate) const ENDLESS: i32 = i32::MAX;

impl Intervals {
    /// Depths are below 2^30: see [`crate`].
    #[inline(always)]
    pub(crate) fn new(columns: &BlockColumns) -> Self {
        let mut intervals = Self { e: [0; COLUMNS], x: [0; COLUMNS], slant: Slant::default() };
        for i in 0..COLUMNS {
            intervals.e[i] = columns.e[i] as i32;
            intervals.x[i] = if columns.x[i] >= FREE_TO_END { ENDLESS } else { columns.x[i] as i32 };
        }
        intervals
    }

    /// Returns level intervals with the slant's rise.
    #[inline(always)]
    pub(crate) fn risen(&self, slant: Slant) -> Self {
        let rises = slant.rises();
        let mut risen = Self { e: self.e, x: self.x, slant };
        for ((e, x), rise) in risen.e.iter_mut().zip(&mut risen.x).zip(rises) {
            *e += rise;
            *x = if *x == ENDLESS { ENDLESS } else { *x + rise };
        }
        risen
    }
}
