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
    pub(crate) fn new(columns: &BlockColumns) -> Self {
        let x = columns.x.map(|x| if x >= FREE_TO_END { ENDLESS } else { x as i32 });
        Self { e: columns.e.map(|e| e as i32), x, slant: Slant::default() }
    }

    pub(crate) fn risen(&self, slant: Slant) -> Self {
        let rises = slant.rises();
        Self {
            e: std::array::from_fn(|i| self.e[i] + rises[i]),
            x: std::array::from_fn(|i| self.x[i].saturating_add(rises[i])),
            slant,
        }
    }
}
