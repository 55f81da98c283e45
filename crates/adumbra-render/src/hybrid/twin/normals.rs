//! Means of packed normals. Twin of core/hybrid_normals.wgsl, byte for byte.

use crate::octahedral::NONE;

/// Twin of `adumbra_hybrid_normal`. The vector has length 2^14.
fn fixed(bytes: [u8; 2]) -> [i32; 3] {
    let e = bytes.map(|b| i32::from(b) - 128);
    let z = 127 - e[0].abs() - e[1].abs();
    let fold = (-z).max(0);
    let [x, y] = e.map(|c| if c >= 0 { c - fold } else { c + fold });
    let root = (((x * x + y * y + z * z) as u32) << 16).isqrt() as i32;
    [x, y, z].map(|c| (c << 22) / root)
}

/// Twin of `adumbra_hybrid_normal_mean`.
pub(super) fn mean(normals: [[u8; 2]; 4]) -> [u8; 2] {
    let mut sum = [0; 3];
    for normal in normals.into_iter().filter(|n| *n != NONE) {
        let n = fixed(normal);
        sum = [0, 1, 2].map(|a| sum[a] + n[a]);
    }
    let [x, y, z] = sum;
    let size = x.abs() + y.abs() + z.abs();
    if size == 0 {
        return NONE;
    }
    let sign = |c: i32| if c >= 0 { 1 } else { -1 };
    let folded = if z < 0 { [(size - y.abs()) * sign(x), (size - x.abs()) * sign(y)] } else { [x, y] };
    folded.map(|c| ((254 * c + 257 * size) / (2 * size)) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::octahedral::{decode, encode};

    /// Tests every pair of bytes that encodes a vector. On the rim, two pairs may encode the same vector.
    #[test]
    fn mean_of_one_normal_is_that_normal() {
        let mut others = 0;
        for one in (1..=255).flat_map(|a| (1..=255).map(move |b| [a, b])) {
            let found = mean([one; 4]);
            assert_eq!(mean([NONE, one, NONE, NONE]), found);
            let [expected, back] = [one, found].map(decode);
            assert!((0..3).all(|a| (expected[a] - back[a]).abs() < 1e-6), "{one:?}: {found:?}");
            others += usize::from(found != one);
        }
        assert!(others <= 4 * 127, "{others}");
        assert_eq!(mean([NONE; 4]), NONE);
    }

    #[test]
    fn mean_matches_unit_vectors_to_a_byte() {
        let n = [[128, 255], [255, 128], [128, 128], [200, 60]];
        let sets = (0..5000_u32).map(|i| {
            n.map(|[a, b]: [u8; 2]| {
                let turn = |c: u8, by: u32| (u32::from(c) + i * by) as u8 % 255 + 1;
                [turn(a, 7), turn(b, 31)]
            })
        });
        let (mut others, mut worst) = (0, 0.0_f64);
        for set in sets {
            let unit = set.map(|b| decode(b).map(f64::from));
            let sum = [0, 1, 2].map(|a| unit.iter().map(|u| u[a]).sum::<f64>());
            let length = sum.iter().map(|c| c * c).sum::<f64>().sqrt();
            if length < 0.5 {
                continue;
            }
            let found = mean(set);
            others += usize::from(found != encode(sum.map(|c| c as f32)));
            let dot: f64 = (0..3).map(|a| f64::from(decode(found)[a]) * sum[a] / length).sum();
            worst = worst.max(libm::acos(dot.min(1.0)).to_degrees());
        }
        println!("{others} others, worst {worst} degrees");
        assert!(others < 25 && worst < 0.96, "{others} {worst}");
    }
}
