//! Depths in fixed point, and the planes that give the depths of triangles.

/// Fractional steps per texel, and per voxel of depth.
pub(crate) const SUBTEXEL: i64 = 1 << SUBTEXEL_BITS;
/// Binary digits of such a fraction.
pub(crate) const SUBTEXEL_BITS: u32 = 8;
/// Smallest depth in voxels, relative to the grid's near end.
pub(super) const DEPTH_MIN_VOXELS: f64 = -1_048_576.0;
/// Largest depth in voxels: the longest grid along the light.
pub(crate) const DEPTH_MAX_VOXELS: f64 = 2_097_152.0;
/// Depth in 1/256 voxels.
pub type FixedDepth = i32;

/// Rounds a depth in voxels to the nearest 1/256.
#[inline(always)]
pub(crate) fn fixed_depth(z: f64) -> FixedDepth {
    fixed_depth_within(z.clamp(DEPTH_MIN_VOXELS, DEPTH_MAX_VOXELS))
}

/// [`fixed_depth`] of a depth from [`DEPTH_MIN_VOXELS`] to [`DEPTH_MAX_VOXELS`].
#[inline(always)]
fn fixed_depth_within(z: f64) -> FixedDepth {
    let steps = (z - DEPTH_MIN_VOXELS) * SUBTEXEL as f64 + 0.5;
    floor_to_integer(steps) - (-DEPTH_MIN_VOXELS as i32) * SUBTEXEL as i32
}

/// Rounds a number from 0 to 2^31 - 1 down. Unlike a conversion with `as`, it compiles to vector
/// instructions.
#[inline(always)]
fn floor_to_integer(v: f64) -> i32 {
    /// Numbers from this one to its double have no fraction bits.
    const WHOLE: f64 = (1_u64 << 52) as f64;
    let nearest = v + WHOLE;
    let rounded_up = nearest - WHOLE > v;
    nearest.to_bits() as i32 - i32::from(rounded_up)
}

/// Returns the largest number of 1/256 voxels that is not deeper than `z`.
#[inline(always)]
pub(crate) fn floor_fixed_depth(z: f64) -> FixedDepth {
    fixed_depth(z - 0.5 / SUBTEXEL as f64)
}

/// A triangle's supporting plane: z = z0 + gx (x - x0) + gy (y - y0), in grid units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    origin: [f64; 3],
    pub(crate) gradient: [f64; 2],
}

impl Plane {
    /// Returns a replacement for the plane of an edge-on triangle: its nearest depth if it faces the sun,
    /// otherwise its deepest.
    pub(super) fn level([x, y, _]: [f64; 3], faces_sun: bool, z: [f64; 3]) -> Self {
        let nearest = z[0].min(z[1]).min(z[2]);
        let deepest = z[0].max(z[1]).max(z[2]);
        Self { origin: [x, y, if faces_sun { nearest } else { deepest }], gradient: [0.0; 2] }
    }

    /// Returns the plane through the grid's corner with this gradient.
    pub(crate) fn at_origin(gradient: [f64; 2]) -> Self {
        Self { origin: [0.0; 3], gradient }
    }

    /// Returns |dz/dx| + |dz/dy|.
    pub(crate) fn gradient_sum(&self) -> f64 {
        self.gradient[0].abs() + self.gradient[1].abs()
    }

    /// Returns the tangent of the angle between the plane's normal and the light.
    pub(crate) fn slope(&self) -> f64 {
        let [gx, gy] = self.gradient;
        (gx * gx + gy * gy).sqrt()
    }

    /// Returns the plane's value (a depth, or any attribute that is linear over the triangle) at (x, y).
    #[inline(always)]
    pub(crate) fn at(&self, x: f64, y: f64) -> f64 {
        self.origin[2] + self.gradient[1] * (y - self.origin[1]) + self.gradient[0] * (x - self.origin[0])
    }

    /// Returns [`Self::at`] for eight points of a row.
    #[inline(always)]
    pub(crate) fn along(&self, x: &[f64; 8], y: f64) -> [f64; 8] {
        let mut z = [0.0; 8];
        for (z, x) in z.iter_mut().zip(x) {
            *z = self.at(*x, y);
        }
        z
    }
}

/// Clamps eight depths to `[low, high]` and rounds them to 1/256 voxel.
#[inline(always)]
pub(crate) fn depths_within([low, high]: [f64; 2], z: [f64; 8]) -> [FixedDepth; 8] {
    let mut depths = [0; 8];
    for (depth, z) in depths.iter_mut().zip(z) {
        // Unlike `max` and `min`, these are one instruction each.
        let z = if z > low { z } else { low };
        *depth = fixed_depth_within(if z < high { z } else { high });
    }
    depths
}

/// Returns the plane through three corners. Returns `None` if rounding makes the plane miss one of them, as
/// with corners on a line: the known depth bounds of the triangle would not hold for it.
pub(super) fn depth_plane(c: &[[f64; 3]; 3]) -> Option<Plane> {
    let holds =
        |plane: &Plane| c.iter().all(|&[x, y, z]| (plane.at(x, y) - z).abs() <= 1.0 / SUBTEXEL as f64);
    plane_through(c, c.map(|corner| corner[2])).filter(holds)
}

/// Returns the plane over (x, y) of an attribute with these values at the corners. Returns `None` for corners
/// on a line.
pub(crate) fn plane_through(c: &[[f64; 3]; 3], z: [f64; 3]) -> Option<Plane> {
    let (x1, y1, z1) = (c[1][0] - c[0][0], c[1][1] - c[0][1], z[1] - z[0]);
    let (x2, y2, z2) = (c[2][0] - c[0][0], c[2][1] - c[0][1], z[2] - z[0]);
    let area = x1 * y2 - x2 * y1;
    let gradient = [(z1 * y2 - z2 * y1) / area, (x1 * z2 - x2 * z1) / area];
    gradient.iter().all(|g| g.is_finite()).then_some(Plane { origin: [c[0][0], c[0][1], z[0]], gradient })
}
