//! Octahedral encoding of a unit vector in two bytes: the CPU twin of core/octahedral.wgsl, which has the
//! table of bytes.
//!
//! Source: Cigolle, Donow, Evangelakos, Mara, McGuire, Meyer, *A Survey of Efficient Representations for
//! Independent Unit Vectors*, 2014. Departure: rounds to nearest, which is the survey's plain variant.

/// Two bytes that encode no vector.
pub const NONE: [u8; 2] = [0; 2];

/// Encodes a direction as two bytes, each 1 to 255. The direction need not have unit length but must not be
/// zero. The error of the decoded direction is at most 0.95 degrees.
pub fn encode(direction: [f32; 3]) -> [u8; 2] {
    let [x, y, z] = direction;
    let sum = x.abs() + y.abs() + z.abs();
    let flat = [x / sum, y / sum];
    let sign = |c: f32| if c >= 0.0 { 1.0 } else { -1.0 };
    let folded = if z < 0.0 {
        [(1.0 - flat[1].abs()) * sign(flat[0]), (1.0 - flat[0].abs()) * sign(flat[1])]
    } else {
        flat
    };
    folded.map(|c| (127.0 * c + 128.5).floor() as u8)
}

/// Decodes two bytes to a unit vector. The result for [`NONE`] is meaningless.
pub fn decode(bytes: [u8; 2]) -> [f32; 3] {
    let e = bytes.map(|b| (f32::from(b) - 128.0) / 127.0);
    let z = 1.0 - e[0].abs() - e[1].abs();
    let fold = (-z).max(0.0);
    let [x, y] = e.map(|c| if c >= 0.0 { c - fold } else { c + fold });
    let length = (x * x + y * y + z * z).sqrt();
    [x / length, y / length, z / length]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encode_matches_the_table() {
        assert_eq!(encode([0.0, 0.0, 1.0]), [128, 128]);
        assert_eq!(encode([0.0, 1.0, 0.0]), [128, 255]);
        assert_eq!(encode([0.6, 0.0, -0.8]), [255, 201]);
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                let mut n = [0.0; 3];
                n[axis] = sign;
                assert_eq!(decode(encode(n)), n);
            }
        }
    }

    /// Tests directions of a Fibonacci lattice over the sphere.
    #[test]
    fn directions_round_trip_within_a_degree_without_zero_bytes() {
        let count = 200_000;
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        for i in 0..count {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let (sin, cos) = libm::sincos(2.399963229728653 * f64::from(i));
            let radius = (1.0 - z * z).sqrt();
            let n = [radius * cos, radius * sin, z];
            let bytes = encode(n.map(|c| c as f32));
            assert!(!bytes.contains(&0), "{n:?}");
            let back = decode(bytes).map(f64::from);
            let apart: f64 = (0..3).map(|a| (n[a] - back[a]) * (n[a] - back[a])).sum::<f64>().sqrt();
            let degrees = 2.0 * libm::asin(0.5 * apart).to_degrees();
            (worst, sum) = (worst.max(degrees), sum + degrees);
        }
        let mean = sum / f64::from(count);
        println!("worst {worst} degrees, mean {mean}");
        assert!(worst < 0.95 && mean < 0.35, "{worst} {mean}");
    }
}
