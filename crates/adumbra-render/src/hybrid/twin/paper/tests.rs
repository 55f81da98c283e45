use super::*;
use crate::hybrid::MergeTest;
use crate::hybrid::settings::PlaneUnits;
use crate::octahedral::{NONE, encode};

const PLANE: MergeTest = MergeTest::Plane { tolerance_texels: 0.5 };

/// A scene with a step, a slope, a checkerboard and an area without casters, with normals.
fn scene(side: usize) -> (DepthImage, Vec<[u8; 2]>) {
    let depth = |x: usize, y: usize| match (x < side / 2, y < side / 2) {
        (true, true) => 0.25 + (x as f32 * 0.3 + y as f32 * 0.1) / 4096.0,
        (true, false) => 1.0,
        (false, true) => [0.2, 0.7][(x + y) % 2],
        (false, false) => [0.3, 0.31, 0.8][(x / 5 + y / 7) % 3],
    };
    let texels: Vec<f32> = (0..side * side).map(|i| depth(i % side, i / side)).collect();
    let normal = |i: usize| encode([(i % 7) as f32 - 3.0, (i / side % 5) as f32 - 1.0, 1.5 - (i % 3) as f32]);
    let normals = (0..side * side).map(|i| if texels[i] == 1.0 { NONE } else { normal(i) }).collect();
    (DepthImage::new(side, texels).unwrap(), normals)
}

#[test]
fn texels_have_the_worked_values() {
    let mut texels = vec![0.75; 64];
    texels[3 * 8 + 5] = 0.25;
    let mut normals = vec![encode([1.0, 0.0, 0.0]); 64];
    normals[3 * 8 + 5] = encode([0.0, 1.0, 0.0]);
    let image = DepthImage::new(8, texels).unwrap();
    let units = PlaneUnits::new(MergeTest::Paper, 0.01);
    let settings =
        MergeSettings { merges: 1, test: MergeTest::Paper, precision: DepthPrecision::Bits32, units };
    let map = HybridPaper::build(&image, &normals, settings).unwrap();
    assert_eq!(map.found(5, 3), ([0x0003_0005, 0x3e80_0000, 0, 0x4000_ff80], 0));
    // Only its parent, column 2 and row 1 of the coarsest level, has a list.
    assert_eq!(map.texels[6], [0x0001_0002, 0, 0x8000_0000, 0]);
    assert_eq!(map.links, [[16, 1], [17, 2], [18, 3], [19, HYBRID_NO_LINK]]);
    // A merged texel stores its depth twice, in G and in A.
    let [at, depth, index, rest] = map.texels[0];
    assert_eq!((at, index, rest), (0, 0, 49151 << 16 | 0x80ff));
    assert_eq!(f32::from_bits(depth), 0.75);
}

#[test]
fn unorm16_rounds_to_nearest_and_keeps_16_bit_depth() {
    for k in 0..=65535_u32 {
        assert_eq!(unorm16(k as f32 / 65535.0), k);
        let beside = (f64::from(k) + 0.49) / 65535.0;
        assert_eq!(unorm16(beside.min(1.0) as f32), k);
    }
}

#[test]
fn lists_find_the_texels_of_the_compact_tree() {
    let (image, normals) = scene(64);
    for test in [PLANE, MergeTest::Paper] {
        for precision in [DepthPrecision::Bits32, DepthPrecision::Bits16] {
            for merges in 1..=3 {
                let units = PlaneUnits::new(test, 1.0 / 4096.0);
                let settings = MergeSettings { merges, test, precision, units };
                let tree = HybridTree::build(&image, settings).unwrap();
                let map = HybridPaper::build(&image, &normals, settings).unwrap();
                assert!(tree.split[0] > 50, "{:?}", tree.split);
                assert_eq!(map.compact(), tree, "{test:?} {precision:?} {merges}");
                for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
                    assert_eq!(map.texel(x, y), tree.texel(x, y), "{test:?} {precision:?} {merges} {x} {y}");
                    let ([at, _, _, rest], level) = map.found(x, y);
                    assert_eq!(i64::from(at & 0xffff), x >> level);
                    assert_eq!(i64::from(at >> 16), y >> level);
                    // Finest texels have no normal exactly where there is no caster.
                    let is_empty = image.texels()[(y * 64 + x) as usize] == 1.0;
                    assert!(level > 0 || (rest & 0xffff == 0) == is_empty);
                }
            }
        }
    }
}

#[test]
fn finds_texels_in_lists_of_any_order() {
    let (image, normals) = scene(32);
    let units = PlaneUnits::new(PLANE, 1.0 / 4096.0);
    let settings = MergeSettings { merges: 2, test: PLANE, precision: DepthPrecision::Bits32, units };
    let map = HybridPaper::build(&image, &normals, settings).unwrap();
    let mut turned = map.clone();
    for four in turned.links.as_chunks_mut::<4>().0 {
        let numbers = four.map(|[number, _]| number);
        for (link, number) in four.iter_mut().zip(numbers.into_iter().rev()) {
            link[0] = number;
        }
    }
    assert_ne!(map.links, turned.links);
    assert_eq!(map.compact(), turned.compact());
    for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x, y))) {
        assert_eq!(map.found(x, y), turned.found(x, y));
    }
}

#[test]
fn build_rejects_a_wrong_number_of_normals() {
    let (image, normals) = scene(32);
    let units = PlaneUnits::new(PLANE, 0.01);
    let settings = MergeSettings { merges: 2, test: PLANE, precision: DepthPrecision::Bits32, units };
    let built = |normals| HybridPaper::build(&image, normals, settings);
    assert!(built(&normals[1..]).unwrap_err().to_string().contains("1023 normals for 1024 texels"));
}
