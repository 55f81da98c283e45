//! The world-to-grid transform for shaders. A grid and an anchor are converted in `f64` to 32-bit numbers.

use crate::error::{RangeError, RangeField};
use crate::grid::LightGrid;
use crate::query::{FIXED_ONE, MAX_FIXED_SIDE};

/// Largest length of a step, in voxels.
const STEP_VOXELS: f64 = 8.0;

/// The WGSL structure `AdumbraGridTransform`: the transform from positions relative to an anchor to grid
/// positions.
///
/// A position is split into whole steps of 4 to 8 voxels, whose contribution is exact in integers, and a
/// remainder. A look-up is thus accurate to within 1e-5 voxels, however large the grid. Fixed-point numbers
/// have [`FIXED_ONE`] per voxel, and wrap around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridParameters {
    /// Rows of the linear map from world to grid, see [`Frame::axes`](crate::Frame::axes).
    pub axes: [[f32; 3]; 3],
    /// Edges of a voxel, see [`Frame::edges`](crate::Frame::edges). They convert normals.
    pub edges: [[f32; 3]; 3],
    /// Change of the grid position per step along each world axis, in fixed point.
    pub steps: [[i32; 3]; 3],
    /// Remainders of [`GridParameters::steps`], in voxels.
    pub rests: [[f32; 3]; 3],
    /// Grid position of the anchor, in fixed point.
    pub anchor_fixed: [i32; 3],
    /// Remainder of [`GridParameters::anchor_fixed`], in voxels.
    pub anchor_remainder: [f32; 3],
    /// Grid position of the anchor in voxels, rounded to `f32`.
    pub anchor_voxels: [f32; 3],
    /// Number of voxels along x, y and z.
    pub size: [i32; 3],
    /// Voxels per world unit.
    pub voxels_per_world: f32,
    /// World units per step, a power of two.
    pub step_world: f32,
    /// Steps per world unit.
    pub steps_per_world: f32,
}

impl GridParameters {
    /// Size of the structure in bytes.
    pub const BYTES: usize = 272;

    /// Creates the transform for a grid. Positions in the shader are relative to `anchor_world`.
    ///
    /// # Errors
    /// Returns [`RangeError`] if a side has more than [`MAX_FIXED_SIDE`] voxels.
    pub fn new(grid: &LightGrid, anchor_world: [f64; 3]) -> Result<Self, RangeError> {
        let &LightGrid { axes, edges, voxel_size, size, .. } = grid;
        let anchor_voxels = grid.to_grid(anchor_world);
        let longest = size.into_iter().fold(0, u32::max);
        if longest > MAX_FIXED_SIDE {
            const { assert!(MAX_FIXED_SIDE == 516_096, "the message below names the limit") };
            let range = "at most 516096 voxels for look-ups on a GPU; bake at a lower resolution";
            return Err(RangeError::new(RangeField::LongestSide, longest, range));
        }
        // A power of two, so that the shader's products with it are exact.
        let step_world = power_of_two_below(STEP_VOXELS * voxel_size);
        let split_steps: [([i32; 3], [f32; 3]); 3] =
            std::array::from_fn(|world| split(axes.map(|axis| axis[world] * step_world / voxel_size)));
        let (anchor_fixed, anchor_remainder) = split(anchor_voxels);
        Ok(Self {
            axes: axes.map(single),
            edges: edges.map(single),
            steps: split_steps.map(|(step, _)| step),
            rests: split_steps.map(|(_, rest)| rest),
            anchor_fixed,
            anchor_remainder,
            anchor_voxels: single(anchor_voxels),
            size: size.map(|n| n as i32),
            voxels_per_world: (1.0 / voxel_size) as f32,
            step_world: step_world as f32,
            steps_per_world: (1.0 / step_world) as f32,
        })
    }

    /// Appends the structure's little-endian bytes, with WGSL's padding.
    pub(super) fn put(&self, out: &mut Vec<u8>) {
        let start = out.len();
        let floats = |out: &mut Vec<u8>, v: [f32; 3]| put_row(out, v.map(f32::to_bits));
        let integers = |out: &mut Vec<u8>, v: [i32; 3]| put_row(out, v.map(|c| c as u32));
        self.axes.iter().chain(&self.edges).for_each(|&row| floats(out, row));
        self.steps.iter().for_each(|&step| integers(out, step));
        self.rests.iter().for_each(|&rest| floats(out, rest));
        integers(out, self.anchor_fixed);
        floats(out, self.anchor_remainder);
        floats(out, self.anchor_voxels);
        for word in self.size {
            out.extend((word as u32).to_le_bytes());
        }
        for number in [self.voxels_per_world, self.step_world, self.steps_per_world] {
            out.extend(number.to_le_bytes());
        }
        out.resize(start + Self::BYTES, 0);
    }
}

/// Appends three words and their padding.
fn put_row(out: &mut Vec<u8>, words: [u32; 3]) {
    for word in words.into_iter().chain([0]) {
        out.extend(word.to_le_bytes());
    }
}

/// Returns the largest power of two that is at most `x`, which must be a positive normal number.
fn power_of_two_below(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    f64::from_bits(x.to_bits() & EXPONENT)
}

fn single(v: [f64; 3]) -> [f32; 3] {
    v.map(|c| c as f32)
}

/// Splits grid coordinates into wrapped fixed-point numbers and remainders in voxels.
fn split(voxels: [f64; 3]) -> ([i32; 3], [f32; 3]) {
    let one = f64::from(FIXED_ONE);
    let whole = voxels.map(|v| libm::floor(v * one));
    let rest = [0, 1, 2].map(|a| ((voxels[a] * one - whole[a]) / one) as f32);
    // Wrapping is correct because the shader adds modulo 2^32.
    (whole.map(|w| w as i64 as i32), rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_powers_of_two() {
        for (x, expected) in [(8.0, 8.0), (8.0 * 0.999, 4.0), (0.3, 0.25), (1e-9, 2.0_f64.powi(-30))] {
            assert_eq!(power_of_two_below(x), expected, "{x}");
        }
    }
}
