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

/// Translation · rotation · scale. The quaternion (x, y, z, w) is normalised first; a zero quaternion means
/// no rotation.
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

/// Splits a map into a translation, a rotation (x, y, z, w) and a scale. The result is exact for maps that
/// [`compose`] returns. Shear is lost. For a mirrored map, the scale along x is negative.
pub(super) fn decompose(map: &Affine) -> ([f64; 3], [f64; 4], [f64; 3]) {
    let column = |c: usize| map.map(|row| row[c]);
    let length = |c: usize| column(c).iter().map(|v| v * v).sum::<f64>().sqrt();
    let [a, b, c] = [column(0), column(1), column(2)];
    let volume = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
    let scale = [if volume < 0.0 { -length(0) } else { length(0) }, length(1), length(2)];
    if scale.contains(&0.0) {
        return (column(3), [0.0, 0.0, 0.0, 1.0], scale);
    }
    let turn: [[f64; 3]; 3] = std::array::from_fn(|r| std::array::from_fn(|c| map[r][c] / scale[c]));
    // Shepperd's method (1978): compute four times the square of each component, and divide by the largest
    // component.
    let [x, y, z] = [turn[0][0], turn[1][1], turn[2][2]];
    let squares = [1.0 + x - y - z, 1.0 - x + y - z, 1.0 - x - y + z, 1.0 + x + y + z];
    let sums = |r: usize, c: usize| turn[r][c] + turn[c][r];
    let differences = [turn[2][1] - turn[1][2], turn[0][2] - turn[2][0], turn[1][0] - turn[0][1]];
    let largest = (0..4).fold(3, |best, i| if squares[i] > squares[best] { i } else { best });
    let products = match largest {
        0 => [squares[0], sums(0, 1), sums(0, 2), differences[0]],
        1 => [sums(0, 1), squares[1], sums(1, 2), differences[1]],
        2 => [sums(0, 2), sums(1, 2), squares[2], differences[2]],
        _ => [differences[0], differences[1], differences[2], squares[3]],
    };
    (column(3), products.map(|p| p / (2.0 * squares[largest].sqrt())), scale)
}

/// The largest factor by which a map stretches any vector, or up to a third more for maps with shear.
pub(super) fn stretch(map: &Affine) -> f64 {
    // The square root of the largest row sum of the Gram matrix, which for rotation and scale is diagonal.
    let dot = |a: usize, b: usize| map.iter().map(|row| row[a] * row[b]).sum::<f64>().abs();
    (0..3).map(|a| (0..3).map(|b| dot(a, b)).sum::<f64>()).fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decompose_inverts_compose() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for rotation in [
            [0.0, 0.0, 0.0, 1.0],
            [half, 0.0, 0.0, half],
            [0.0, 1.0, 0.0, 0.0],
            [0.5, -0.5, 0.5, 0.5],
            [0.0, 0.0, -0.8, 0.6],
            [0.1, -0.7, 0.7, -0.1],
        ] {
            for scale in [[1.0; 3], [2.0, 3.0, 0.5], [-2.0, 1.0, 1.0]] {
                let map = compose([5.0, -6.0, 7.0], rotation, scale);
                let (translation, found, sizes) = decompose(&map);
                let again = compose(translation, found, sizes);
                let error =
                    (0..12).map(|i| (map[i / 4][i % 4] - again[i / 4][i % 4]).abs()).fold(0.0, f64::max);
                assert!(error < 1e-12, "{rotation:?} {scale:?}: {again:?} for {map:?}");
                assert!((sizes[0] < 0.0) == (scale[0] < 0.0));
            }
        }
        assert_eq!(decompose(&[[0.0; 4]; 3]), ([0.0; 3], [0.0, 0.0, 0.0, 1.0], [0.0; 3]));
    }

    #[test]
    fn stretch_is_the_largest_scale_of_a_map() {
        let map = compose([9.0; 3], [0.5, -0.5, 0.5, 0.5], [0.5, -3.0, 2.0]);
        assert!((stretch(&map) - 3.0).abs() < 1e-12);
        let shear = [[1.0, 1.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
        assert!((golden..golden * 4.0 / 3.0).contains(&stretch(&shear)), "{}", stretch(&shear));
    }
}
