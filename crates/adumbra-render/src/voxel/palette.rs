//! Colours of [`crate::Answer::Voxel`].

/// Linear colours of the levels: from 0, purple, through blue, green and yellow, to 11, peach. Each is
/// lighter than the previous one by the same step and has a distinct hue. The first eight are furthest apart,
/// since most pixels have those levels (Oklab: Björn Ottosson, *A perceptual color space for image
/// processing*, 2020).
pub const VOXEL_LEVEL_COLORS: [[f32; 3]; 12] = [
    [0.326, 0.000, 0.103],
    [0.319, 0.000, 0.417],
    [0.188, 0.045, 0.814],
    [0.029, 0.146, 0.990],
    [0.001, 0.290, 0.559],
    [0.003, 0.394, 0.402],
    [0.003, 0.513, 0.226],
    [0.030, 0.637, 0.016],
    [0.391, 0.614, 0.001],
    [0.752, 0.605, 0.003],
    [0.995, 0.627, 0.212],
    [0.999, 0.733, 0.585],
];

/// Returns the colour of a level. Levels beyond the last have the last one's.
pub fn voxel_level_color(level: u32) -> [f32; 3] {
    VOXEL_LEVEL_COLORS[(level as usize).min(VOXEL_LEVEL_COLORS.len() - 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oklab coordinates of a linear colour.
    fn oklab([r, g, b]: [f32; 3]) -> [f32; 3] {
        let l = (0.412_221_5 * r + 0.536_332_5 * g + 0.051_446 * b).cbrt();
        let m = (0.211_903_5 * r + 0.680_699_5 * g + 0.107_397 * b).cbrt();
        let s = (0.088_302_5 * r + 0.281_718_8 * g + 0.629_978_7 * b).cbrt();
        [
            0.210_454_3 * l + 0.793_617_8 * m - 0.004_072 * s,
            1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s,
            0.025_904 * l + 0.782_771_8 * m - 0.808_675_8 * s,
        ]
    }

    #[test]
    fn palette_grows_lighter_and_keeps_levels_distinct() {
        let labs = VOXEL_LEVEL_COLORS.map(oklab);
        for (i, a) in labs.iter().enumerate() {
            for (j, b) in labs.iter().enumerate().skip(i + 1) {
                let apart = (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f32>().sqrt();
                assert!(apart > 0.075, "{i} and {j}: {apart}");
                assert!(b[0] > a[0] + 0.03, "{i} and {j}: {} {}", a[0], b[0]);
            }
        }
        assert_eq!(voxel_level_color(11), voxel_level_color(20));
    }
}
