//! Decodes merged texels. Twin of core/hybrid_plane.wgsl and core/hybrid_mean.wgsl.

use adumbra_shaders::constants::{HYBRID_DEPTH_STEP, HYBRID_ONE, HYBRID_SLOPE_BITS};

use crate::hybrid::MergeTest;

/// Twin of `adumbra_hybrid_slope`.
pub(super) fn slope(code: i32, unit: i32) -> i32 {
    let size = (code * code * unit) >> HYBRID_SLOPE_BITS;
    if code < 0 { -size } else { size }
}

/// Twin of `adumbra_hybrid_middle`.
pub(super) fn middle(word: u32) -> i32 {
    ((word >> 14) as i32 + 1) * HYBRID_DEPTH_STEP
}

/// Twin of `adumbra_hybrid_leaf`. Returns the depth at the texel's middle and its change per texel to the
/// right and down.
pub(super) fn leaf(test: MergeTest, word: u32, unit: i32) -> [f32; 3] {
    let code = |first: u32| (word << (25 - first)) as i32 >> 25;
    match test {
        MergeTest::Paper => [f32::from_bits(word), 0.0, 0.0],
        MergeTest::Plane { .. } => {
            [middle(word), slope(code(0), unit), slope(code(7), unit)].map(|c| c as f32 / HYBRID_ONE)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plane_leaf_has_the_worked_value() {
        let plane = MergeTest::Plane { tolerance_texels: 0.5 };
        assert_eq!(leaf(plane, 0x4000_0183, 4096), [65537.0 / 131_072.0, 9.0 / HYBRID_ONE, 9.0 / HYBRID_ONE]);
        // Slope codes are signed.
        assert_eq!(leaf(plane, 0x7f, 4096), [1.0 / 131_072.0, -1.0 / HYBRID_ONE, 0.0]);
        assert_eq!(leaf(MergeTest::Paper, 0.25_f32.to_bits(), 0), [0.25, 0.0, 0.0]);
    }
}
