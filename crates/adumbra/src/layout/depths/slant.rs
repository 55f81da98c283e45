//! The gradient of a leaf whose depths are on parallel planes.

/// Number of fraction bits of a gradient.
pub const SLANT_BITS: u32 = 2;

/// Gradient of a leaf's depths along x and y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Slant {
    /// Quarters of a voxel per column along x.
    pub x: i8,
    /// Quarters of a voxel per column along y.
    pub y: i8,
}

impl Slant {
    /// Decodes the second half-word of a slanted leaf.
    #[inline(always)]
    pub fn from_half(half: u32) -> Self {
        Self { x: half as u8 as i8, y: (half >> 8) as u8 as i8 }
    }

    /// Encodes the second half-word of a slanted leaf.
    pub fn to_half(self) -> u16 {
        u16::from(self.x as u8) | u16::from(self.y as u8) << 8
    }

    /// Returns by how much a column switches nearer to the sun than the deepest corner of its plane, in
    /// voxels, rounded up.
    #[inline(always)]
    pub fn rise(self, column: u32) -> u32 {
        (self.quarters((column & 7) as i32, (column >> 3) as i32) >> SLANT_BITS) as u32
    }

    /// Returns 3 more than four times the rise of a column, so that a shift by [`SLANT_BITS`] rounds it up.
    /// The column may be in a neighbouring leaf, where the plane may be behind its deepest corner.
    #[inline(always)]
    pub(crate) fn quarters(self, x: i32, y: i32) -> i32 {
        let along = |g: i8, at: i32| i32::from(g) * (at - if g > 0 { 7 } else { 0 });
        (1 << SLANT_BITS) - 1 - along(self.x, x) - along(self.y, y)
    }

    /// Returns the rise of each column, in voxels.
    #[inline(always)]
    pub fn rises(self) -> [i32; 64] {
        let mut rises = [0; 64];
        for (column, rise) in (0..).zip(&mut rises) {
            *rise = self.rise(column) as i32;
        }
        rises
    }

    /// Returns the largest rise of all columns, in voxels.
    pub fn largest_rise(self) -> u32 {
        let quarters = 7 * (u32::from(self.x.unsigned_abs()) + u32::from(self.y.unsigned_abs()));
        (quarters + (1 << SLANT_BITS) - 1) >> SLANT_BITS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slant_rises_from_the_deepest_corner() {
        let slant = Slant { x: 8, y: -4 };
        assert_eq!((slant.rise(7), slant.rise(0), slant.rise(63)), (0, 14, 7));
        assert_eq!((slant.rise(56), slant.largest_rise()), (21, 21));
        assert_eq!(Slant::from_half(slant.to_half().into()), slant);
        assert_eq!(Slant { x: -128, y: -128 }.largest_rise(), 448);
    }

    #[test]
    fn columns_rise_from_zero_to_the_largest_rise_for_every_gradient() {
        for half in 0..=u32::from(u16::MAX) {
            let slant = Slant::from_half(half);
            let rises = (0..64).map(|column| slant.rise(column));
            assert_eq!(rises.clone().min(), Some(0), "{slant:?}");
            assert_eq!(rises.max(), Some(slant.largest_rise()), "{slant:?}");
        }
    }
}
