//! Affine maps as 3 × 4 matrices, row major, as in [`crate::Instance::world_from_mesh`].

/// Row r maps p to `m[r][0..3] · p + m[r][3]`.
pub(super) type Affine = [[f64; 4]; 3];

/// The identity map.
pub(super) const IDENTITY: Affine = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// `a · b`: first `b`, then `a`.
pub(super) fn multiply(a: &Affine, b: &Affine) -> Affine {
    std::array::from_fn(|r| {
        std::array::from_fn(|c| {
            let product = a[r][0] * b[0][c] + a[r][1] * b[1][c] + a[r][2] * b[2][c];
            if c == 3 { product + a[r][3] } else { product }
        })
    })
}

/// The affine part of a column-major 4×4 matrix.
pub(super) fn from_columns(m: &[f64; 16]) -> Affine {
    std::array::from_fn(|r| std::array::from_fn(|c| m[c * 4 + r]))
}

/// Whether all twelve numbers are finite, even as `f32`.
pub(super) fn is_finite(m: &Affine) -> bool {
    m.iter().flatten().all(|&v| (v as f32).is_finite())
}

/// Translation · rotation · scale. The quaternion (x, y, z, w) is normalised first; a zero quaternion means no
/// rotation.
pub(super) fn compose(translation: [f64; 3], [x, y, z, w]: [f64; 4], scale: [f64; 3]) -> Affine {
    let square = [x, y, z, w].iter().map(|c| c * c).sum::<f64>();
    let k = if square == 0.0 { 0.0 } else { 2.0 / square };
    let turn = [
        [1.0 - k * (y * y + z * z), k * (x * y - z * w), k * (x * z + y * w)],
        [k * (x * y + z * w), 1.0 - k * (x * x + z * z), k * (y * z - x * w)],
        [k * (x * z - y * w), k * (y * z + x * w), 1.0 - k * (x * x + y * y)],
    ];
    std::array::from_fn(|r| {
        std::array::from_fn(|c| if c == 3 { translation[r] } else { turn[r][c] * scale[c] })
    })
}
