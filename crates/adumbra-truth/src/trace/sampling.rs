//! Directions for soft sun shadows and ambient occlusion: stratified, rotated by a seed, and deterministic on
//! every machine.
//!
//! Samples are Hammersley points. The first coordinate is stratified and jittered. The second is the base-2
//! radical inverse, rotated modulo one (Cranley, Patterson, *Randomization of Number Theoretic Methods for
//! Multiple Integration*, 1976). Frame: Duff et al., *Building an Orthonormal Basis, Revisited*, 2017. Sine
//! and cosine come from `libm`.

use std::f64::consts::TAU;

/// `count` points in the unit square.
pub(super) fn points(count: u32, seed: u64) -> impl Iterator<Item = [f64; 2]> {
    let turn = to_unit(mix(seed));
    (0..count).map(move |i| {
        let jitter = to_unit(mix(seed ^ mix(u64::from(i) + 1)));
        let inverse = f64::from(i.reverse_bits()) / 4_294_967_296.0;
        let second = inverse + turn;
        [(f64::from(i) + jitter) / f64::from(count), if second >= 1.0 { second - 1.0 } else { second }]
    })
}

/// Two unit vectors that form a right-handed frame, with the unit vector `n` as the third.
pub(super) fn frame(n: [f64; 3]) -> [[f64; 3]; 2] {
    let sign = 1.0_f64.copysign(n[2]);
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    [[1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]], [b, sign + n[1] * n[1] * a, -n[1]]]
}

/// The direction with the component `height` along `n`, rotated about it by
/// `turns` (1 is a full circle); `flat² + height² = 1`.
pub(super) fn around(n: [f64; 3], [x, y]: [[f64; 3]; 2], flat: f64, height: f64, turns: f64) -> [f64; 3] {
    let (sin, cos) = libm::sincos(TAU * turns);
    std::array::from_fn(|r| n[r] * height + (x[r] * cos + y[r] * sin) * flat)
}

/// Sine and cosine of the angle to the axis, for directions uniformly distributed over a spherical cap of
/// half-angle `half` radians; `u` is in 0 .. 1.
pub(super) fn cap(u: f64, half: f64) -> (f64, f64) {
    let s = libm::sin(0.5 * half);
    // 1 - cos, without the cancellation at small angles.
    let depth = u * 2.0 * s * s;
    ((depth * (2.0 - depth)).max(0.0).sqrt(), 1.0 - depth)
}

/// The finalizer of SplitMix64 (Steele, Lea, Flood 2014).
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The upper 53 bits as a number in 0 .. 1.
fn to_unit(x: u64) -> f64 {
    (x >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use adumbra::grid::vec3::{dot, normalize};

    #[test]
    fn sampling_points_are_stratified_and_vary_with_the_seed() {
        let a: Vec<_> = points(64, 7).collect();
        assert_eq!(a, points(64, 7).collect::<Vec<_>>());
        assert_ne!(a, points(64, 8).collect::<Vec<_>>());
        for axis in 0..2 {
            let mut strata: Vec<u32> = a.iter().map(|p| ((p[axis] * 64.0) as u32).min(63)).collect();
            strata.sort_unstable();
            strata.dedup();
            assert!(strata.len() >= 63, "{axis}: {}", strata.len());
        }
    }

    #[test]
    fn sampling_frame_is_orthonormal() {
        for n in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.3, -0.4, 0.5], [1e-9, 0.0, -1.0]] {
            let n = normalize(n);
            let [x, y] = frame(n);
            for (a, b, expected) in [(x, x, 1.0), (y, y, 1.0), (x, y, 0.0), (x, n, 0.0), (y, n, 0.0)] {
                assert!((dot(a, b) - expected).abs() < 1e-12, "{n:?}");
            }
        }
    }

    #[test]
    fn sampling_cap_reaches_its_rim() {
        for half in [1e-9, 0.005, 1.0, 3.0] {
            let (sin, cos) = cap(1.0, half);
            assert!((libm::atan2(sin, cos) - half).abs() < 1e-7 * half, "{half}");
            assert_eq!(cap(0.0, half), (0.0, 1.0));
        }
    }
}
