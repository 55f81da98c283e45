use super::*;

const PLANE: MergeTest = MergeTest::Plane { tolerance_texels: 0.5 };

fn tree(side: usize, merges: u32, test: MergeTest, depth: impl Fn(usize, usize) -> f64) -> HybridTree {
    let texels = (0..side * side).map(|i| depth(i % side, i / side) as f32).collect();
    let image = DepthImage::new(side, texels).unwrap();
    let units = PlaneUnits::new(test, 1.0 / 1024.0);
    let precision = DepthPrecision::Bits32;
    HybridTree::build(&image, MergeSettings { merges, test, precision, units }).unwrap()
}

#[test]
fn image_rejects_invalid_depths() {
    let wrong = |side, texels| DepthImage::new(side, texels).unwrap_err().to_string();
    let mut texels = vec![0.5; 16];
    texels[6] = f32::NAN;
    assert!(wrong(4, texels).contains("NaN at column 2, row 1"));
    assert!(wrong(4, vec![1.5; 16]).contains("1.5"));
    assert!(wrong(3, vec![0.5; 9]).contains("power of two"));
    assert!(wrong(4, vec![0.5; 15]).contains("15 texels"));
    let image = DepthImage::new(4, vec![0.5; 16]).unwrap();
    let units = PlaneUnits::new(PLANE, 0.01);
    let settings = MergeSettings { merges: 3, test: PLANE, precision: DepthPrecision::Bits32, units };
    assert!(HybridTree::build(&image, settings).is_err());
}

#[test]
fn image_of_one_depth_merges_all_the_way() {
    for test in [PLANE, MergeTest::Paper] {
        for depth in [0.0, 1.0] {
            let t = tree(32, 3, test, |_, _| depth);
            assert_eq!((t.words.len(), t.split, t.shares()), (16, [0; 3], [0.0, 0.0, 0.0, 1.0]));
            let (found, level) = t.texel(9, 30);
            // A plane quantizes depth in steps of 2^-17.
            assert!(level == 3 && (f64::from(found) - depth).abs() <= 1.0 / 131_072.0, "{found}");
        }
    }
}

#[test]
fn checkerboard_does_not_merge() {
    for test in [PLANE, MergeTest::Paper] {
        let t = tree(32, 2, test, |x, y| if (x + y) % 2 == 0 { 0.1 } else { 0.9 });
        assert_eq!((t.split, t.shares()), ([256, 64, 0], [1.0, 0.0, 0.0, 0.0]));
        assert_eq!((t.texel(4, 4), t.texel(5, 4)), ((0.1, 0), (0.9, 0)));
    }
}

#[test]
fn single_texel_keeps_its_depth_and_splits_only_its_parents() {
    let t = tree(64, 3, PLANE, |x, y| if (x, y) == (21, 38) { 0.2 } else { 0.8 });
    assert_eq!(t.split, [1, 1, 1]);
    assert_eq!(t.texel(21, 38), (0.2, 0));
    assert_eq!((t.texel(20, 38).1, t.texel(22, 38).1, t.texel(16, 32).1, t.texel(0, 0).1), (0, 1, 2, 3));
    let mut counts = [0.0; 4];
    for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
        counts[t.texel(x, y).1 as usize] += 1.0;
    }
    assert_eq!(counts, [4.0, 12.0, 48.0, 4032.0]);
    assert_eq!(t.shares(), counts.map(|n| n / 4096.0));
}

#[test]
fn plane_merges_slopes_and_is_never_in_front_of_its_texels() {
    // Steep, grazing and curved surfaces. A texel's edge is 1/1024 of the depth range.
    let shapes: [fn(f64, f64) -> f64; 4] = [
        |x, y| 0.3 + (0.7 * x - 0.2 * y) / 1024.0,
        |x, _| 0.1 + 5.0 * x / 1024.0,
        |x, y| 0.5 + 0.001 * libm::sin(0.3 * x) * libm::cos(0.2 * y),
        |x, y| if x + 0.37 * y > 40.0 { 0.9 } else { 0.3 + 0.5 * y / 1024.0 },
    ];
    for (i, shape) in shapes.iter().enumerate() {
        let t = tree(64, 2, PLANE, |x, y| shape(x as f64, y as f64));
        assert!(t.shares()[2] > 0.3, "shape {i}: {:?}", t.shares());
        for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let behind = f64::from(t.texel(x, y).0) - shape(x as f64, y as f64);
            // The tolerance is half a texel; 1e-6 allows for 32-bit rounding.
            assert!((-1e-6..0.5 / 1024.0 + 1e-6).contains(&behind), "shape {i} at {x}, {y}: {behind}");
        }
    }
}

#[test]
fn paper_test_merges_depths_within_a_quarter() {
    // With depths 0.8, 0.8, 0.8 and d, the mean differs from d by a quarter of d at d = 0.6.
    let of = |d: f64| tree(2, 1, MergeTest::Paper, |x, y| if x + y == 2 { d } else { 0.8 }).split[0];
    assert_eq!((of(0.61), of(0.59)), (0, 1));
    let t = tree(2, 1, MergeTest::Paper, |x, y| if x + y == 2 { 0.61 } else { 0.8 });
    assert!((f64::from(t.texel(0, 0).0) - 0.7525).abs() < 1e-6);
}

#[test]
fn finest_16_bit_texels_round_trip() {
    let texels = (0..64).map(|i| ((i * 977) % 65536) as f32 / 65535.0).collect();
    let image = DepthImage::new(8, texels).unwrap();
    let units = PlaneUnits::new(PLANE, 1.0 / 4096.0);
    let settings = MergeSettings { merges: 1, test: PLANE, precision: DepthPrecision::Bits16, units };
    let t = HybridTree::build(&image, settings).unwrap();
    assert!(t.split[0] > 8, "{:?}", t.split);
    for (i, &depth) in image.texels().iter().enumerate() {
        let (found, level) = t.texel(i as i64 % 8, i as i64 / 8);
        assert!(level > 0 || found == depth, "{i}: {found} {depth}");
    }
}
