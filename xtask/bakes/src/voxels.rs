//! Code shared by the test vectors of all kinds of file: a noise function of voxels, and the voxels whose
//! answers are given.

/// Whether a voxel of the noise is lit.
pub(crate) fn noise(x: u32, y: u32, z: u32) -> bool {
    let mut h = (x << 20 ^ y << 10 ^ z).wrapping_mul(0x9E37_79B1);
    h = (h ^ h >> 15).wrapping_mul(0x85EB_CA77);
    (h ^ h >> 13) & 1 == 1
}

/// Scattered numbers, the same in every run.
pub(crate) struct Scatter(u32);

impl Scatter {
    pub(crate) fn new() -> Self {
        Self(0x9E37_79B9)
    }

    /// Returns the next number, which is below `n`.
    pub(crate) fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((u64::from(self.0) * u64::from(n)) >> 32) as u32
    }
}

/// Returns a point in a voxel, at least a quarter of a voxel from its boundary, so that rounding does not
/// matter.
pub(crate) fn point_in([x, y, z]: [u32; 3]) -> [f64; 3] {
    [f64::from(x) + 0.25, f64::from(y) + 0.5, f64::from(z) + 0.75]
}
