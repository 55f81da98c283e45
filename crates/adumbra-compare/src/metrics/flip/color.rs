//! Colour spaces of FLIP: sRGB, linear RGB, CIE XYZ, CIELAB, and YCxCz, its linear counterpart (Andersson et
//! al. 2020, §4.1).

/// Rows of the matrix from linear sRGB to XYZ (IEC 61966-2-1 primaries, D65).
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
/// Rows of the matrix from XYZ to linear sRGB.
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_398_9, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];

fn turn(rows: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    rows.map(|r| r[0] * v[0] + r[1] * v[1] + r[2] * v[2])
}

/// Returns the white point of CIELAB and YCxCz in XYZ: linear sRGB (1, 1, 1).
fn white() -> [f32; 3] {
    turn(&XYZ_FROM_RGB, [1.0; 3])
}

pub(super) fn linear_from_srgb8(c: u8) -> f32 {
    let c = f32::from(c) / 255.0;
    if c <= 0.040_45 { c / 12.92 } else { libm::powf((c + 0.055) / 1.055, 2.4) }
}

/// Converts linear sRGB to YCxCz: a Y proportional to luminance, from -16 to 100, and two opponent-colour
/// channels.
pub(super) fn ycxcz_from_linear(rgb: [f32; 3]) -> [f32; 3] {
    let (xyz, white) = (turn(&XYZ_FROM_RGB, rgb), white());
    let [x, y, z] = std::array::from_fn(|a| xyz[a] / white[a]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

pub(super) fn linear_from_ycxcz([luma, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (luma + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    let white = white();
    turn(&RGB_FROM_XYZ, std::array::from_fn(|a| relative[a] * white[a]))
}

/// Converts linear sRGB to CIELAB with a* and b* scaled by lightness, because the eye distinguishes dark
/// colours less well (Hunt 1952).
pub(super) fn hunt_lab_from_linear(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let (xyz, white) = (turn(&XYZ_FROM_RGB, rgb), white());
    let [x, y, z] = std::array::from_fn(|a| {
        let t = xyz[a] / white[a];
        if t > DELTA * DELTA * DELTA { libm::cbrtf(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// Returns the HyAB distance between two colours, which suits large differences (Abasi, Tehran, Fairchild
/// 2019).
pub(super) fn hyab(p: [f32; 3], q: [f32; 3]) -> f32 {
    (p[0] - q[0]).abs() + ((p[1] - q[1]).powi(2) + (p[2] - q[2]).powi(2)).sqrt()
}
