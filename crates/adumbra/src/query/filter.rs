//! Filter widths.

use crate::error::{RangeError, RangeField};

/// The texels whose mean a look-up returns, around the point's texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// One texel.
    Nearest,
    /// 3 × 3 texels.
    Box3,
    /// 5 × 5 texels.
    #[default]
    Box5,
    /// 9 × 9 texels.
    Box9,
    /// 17 × 17 texels.
    Box17,
}

impl Filter {
    /// Every filter, the narrowest first.
    pub const ALL: [Self; 5] = [Self::Nearest, Self::Box3, Self::Box5, Self::Box9, Self::Box17];

    /// Returns the width in texels.
    pub const fn width(self) -> u32 {
        match self {
            Self::Nearest => 1,
            Self::Box3 => 3,
            Self::Box5 => 5,
            Self::Box9 => 9,
            Self::Box17 => 17,
        }
    }
}

/// Converts a width in texels, such as one that a user typed.
impl TryFrom<u32> for Filter {
    type Error = RangeError;

    fn try_from(width: u32) -> Result<Self, RangeError> {
        let found = Self::ALL.into_iter().find(|filter| filter.width() == width);
        found.ok_or_else(|| RangeError::new(RangeField::FilterWidth, width, "1, 3, 5, 9 or 17"))
    }
}
