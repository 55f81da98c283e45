//! Hybrid maps built on the GPU from synthetic depth images against the build on the CPU: the words must be
//! equal.

use adumbra_render::hybrid::build::HybridMapBuilder;
use adumbra_render::hybrid::twin::{DepthImage, HybridTree, MergeSettings};
use adumbra_render::hybrid::upload::StartDepth;
use adumbra_render::hybrid::{BuildKind, HybridSettings, MergeTest, PlaneUnits};
use adumbra_render::maps::DepthPrecision;
use adumbra_render::readback::read_buffer;
use adumbra_render::{Gpu, RenderError};

use crate::kit;
use crate::kit::hybrid::check_shares;

/// Sides in texels and numbers of merges.
const SIZES: [(usize, u32); 5] = [(64, 1), (64, 3), (128, 2), (256, 3), (512, 2)];
const TESTS: [&str; 3] = ["test=plane", "test=plane:tolerance=4", "test=paper"];

/// The random number generator splitmix64 (Steele, Lea, Flood, *Fast Splittable Pseudorandom Number
/// Generators*, 2014).
struct Random(u64);

impl Random {
    /// Returns the next number, from 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ z >> 31) as f64 / u64::MAX as f64
    }
}

fn image(side: usize, mut depth: impl FnMut(f64, f64) -> f64) -> DepthImage {
    let texels = (0..side * side).map(|i| depth((i % side) as f64, (i / side) as f64).clamp(0.0, 1.0) as f32);
    DepthImage::new(side, texels.collect()).unwrap()
}

/// Random lines divide the image into patches of planes and waves, a third of them without a caster.
fn piecewise(side: usize, random: &mut Random) -> DepthImage {
    let lines: Vec<[f64; 3]> = (0..4)
        .map(|_| {
            let angle = std::f64::consts::TAU * random.next();
            [libm::cos(angle), libm::sin(angle), (random.next() - 0.5) * side as f64]
        })
        .collect();
    let patches: Vec<[f64; 5]> = (0..16)
        .map(|_| {
            // From level to so steep that no plane fits.
            let steep = libm::pow(10.0, 3.0 * random.next() - 2.0) / side as f64;
            let far = if random.next() < 0.33 { 2.0 } else { random.next() };
            [
                far,
                steep * (random.next() - 0.5),
                steep * (random.next() - 0.5),
                0.01 * random.next(),
                20.0 * random.next(),
            ]
        })
        .collect();
    let half = 0.5 * side as f64;
    image(side, |x, y| {
        let (x, y) = (x - half, y - half);
        let bits = (0..4).map(|i| usize::from(lines[i][0] * x + lines[i][1] * y > lines[i][2]) << i);
        let [depth, dx, dy, height, length] = patches[bits.sum::<usize>()];
        depth + dx * x + dy * y + height * libm::sin(x / (length + 1.0)) * libm::cos(y / (length + 2.0))
    })
}

/// Returns test images with their names.
fn images(side: usize, seed: u64) -> Vec<(&'static str, DepthImage)> {
    let mut random = Random(seed);
    let last = side as f64 - 1.0;
    let mut all = vec![
        ("far", image(side, |_, _| 1.0)),
        ("near", image(side, |_, _| 0.0)),
        ("near, negative zero", image(side, |_, _| -0.0)),
        ("checkerboard", image(side, |x, y| if (x + y) % 2.0 == 0.0 { 0.1 } else { 0.9 })),
        ("checkerboard of extremes", image(side, |x, y| (x + y) % 2.0)),
        ("one texel", image(side, |x, y| if (x, y) == (21.0, 38.0) { 0.2 } else { 0.8 })),
        ("last texel", image(side, |x, y| if (x, y) == (last, last) { 0.2 } else { 1.0 })),
        ("steep ramp", image(side, |x, _| x / last)),
        ("steeper ramp", image(side, |x, y| (8.0 * x + 3.0 * y) / last % 1.0)),
        ("noise", image(side, |_, _| random.next())),
    ];
    let mut random = Random(seed + 1);
    // Near the threshold of the paper's test.
    all.push(("noise of a quarter", image(side, |_, _| 0.55 + 0.25 * random.next())));
    // Near the plane test's tolerance.
    let rough = 1.0 / side as f64;
    all.push(("noise on a slope", image(side, |x, y| 0.2 + 0.3 * rough * (x + y) + rough * random.next())));
    for name in ["patches", "other patches", "more patches"] {
        all.push((name, piecewise(side, &mut random)));
    }
    all
}

fn settings(side: usize, merges: u32, test: &str, depth: DepthPrecision, build: BuildKind) -> HybridSettings {
    let read = HybridSettings::from_spec(&format!("hrsm:{test}").parse().unwrap()).unwrap();
    let start = side as u32;
    HybridSettings { start, target: start >> merges, depth, build, ..read }
}

/// Builds a map and returns the words in use and the numbers of blocks that did not merge.
fn built(gpu: &Gpu, builder: &HybridMapBuilder) -> (Vec<u32>, [u32; 3]) {
    let mut encoder = gpu.encoder("test");
    builder.encode(&mut encoder);
    gpu.finish(encoder.finish()).unwrap();
    let counts = builder.counts(gpu).unwrap();
    let bytes = read_buffer(gpu, builder.words()).unwrap();
    let words = bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b));
    (words.take(counts.words as usize).collect(), counts.split)
}

fn check_images(gpu: &Gpu, (side, merges): (usize, u32), precision: DepthPrecision) {
    let start = StartDepth::new(gpu, side as u32, precision).unwrap();
    let images = images(side, 5 + merges as u64);
    for test in TESTS {
        let of = |kind| settings(side, merges, test, precision, kind);
        let builders = [BuildKind::Sweep, BuildKind::Blocks].map(|kind| {
            let builder = HybridMapBuilder::new(gpu, &of(kind), start.view()).unwrap();
            (kind, builder)
        });
        let merge = of(BuildKind::Sweep).test;
        let units = PlaneUnits::new(merge, 1.0 / side as f64);
        let mut merged = 0;
        for (name, image) in &images {
            start.write(gpu, image).unwrap();
            let held = start.read(gpu).unwrap();
            let twin =
                HybridTree::build(&held, MergeSettings { merges, test: merge, precision, units }).unwrap();
            check_shares(&twin, &format!("{name}, {side} texels, {merges} merges, {test}"));
            merged += usize::from(twin.shares()[0] < 1.0 && twin.split[0] > 0);
            for (kind, builder) in &builders {
                builder.write(gpu, units);
                let first = built(gpu, builder);
                let what = format!("{name}, {side} texels, {merges} merges, {test}, {precision:?}, {kind:?}");
                assert_eq!(first.1, twin.split, "{what}");
                assert_eq!(first.0.len(), twin.words.len(), "{what}");
                let apart = first.0.iter().zip(&twin.words).position(|(a, b)| a != b);
                assert_eq!(apart, None, "{what}: the first word that differs");
                assert!(first == built(gpu, builder), "{what}: another build, another map");
            }
        }
        // Some images are partly merged: neither entirely merged nor entirely split.
        assert!(merged >= 3, "{test}: {merged}");
    }
}

#[test]
fn gpu_build_matches_twin_on_small_images() {
    let gpu = kit::gpu();
    check_images(&gpu, (64, 3), DepthPrecision::Bits32);
    check_images(&gpu, (64, 1), DepthPrecision::Bits16);
}

#[test]
#[ignore = "slow: large hybrid maps"]
fn gpu_build_matches_twin_on_32_bit_images() {
    let gpu = kit::gpu();
    SIZES.iter().for_each(|&size| check_images(&gpu, size, DepthPrecision::Bits32));
}

#[test]
#[ignore = "slow: large hybrid maps"]
fn gpu_build_matches_twin_on_16_bit_images() {
    let gpu = kit::gpu();
    SIZES.iter().for_each(|&size| check_images(&gpu, size, DepthPrecision::Bits16));
}

#[test]
fn upload_keeps_every_depth() {
    let gpu = kit::gpu();
    for precision in [DepthPrecision::Bits32, DepthPrecision::Bits16] {
        let start = StartDepth::new(&gpu, 64, precision).unwrap();
        for (name, image) in images(64, 3) {
            start.write(&gpu, &image).unwrap();
            let held = start.read(&gpu).unwrap();
            let worst =
                image.texels().iter().zip(held.texels()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let step = if precision == DepthPrecision::Bits16 { 1.0 / 65535.0 } else { 0.0 };
            // GPUs convert to fixed point within 0.6 steps (Direct3D 11.3 Functional Specification, 3.2.3.6).
            let rounding = if gpu.is_software() { 0.5001 } else { 0.6 };
            assert!(worst <= rounding * step, "{name}, {precision:?}: {worst}");
        }
    }
}

#[test]
fn upload_rejects_wrong_sizes_and_invalid_depths() {
    let gpu = kit::gpu();
    let start = StartDepth::new(&gpu, 64, DepthPrecision::Bits32).unwrap();
    let error = start.write(&gpu, &image(32, |_, _| 0.5)).unwrap_err();
    assert!(error.to_string().contains("32 x 32 texels for a map of 64 x 64"), "{error}");
    for wrong in [f32::NAN, f32::INFINITY, -0.1, 1.1] {
        let mut texels = vec![0.5; 64 * 64];
        texels[100] = wrong;
        let error = DepthImage::new(64, texels).unwrap_err();
        assert!(matches!(error, RenderError::DepthImage { .. }), "{error}");
        assert!(error.to_string().contains("column 36, row 1"), "{error}");
    }
}

#[test]
fn plane_map_is_within_the_tolerance_behind_the_image() {
    // Checks the meaning of the words, independently of how they were built.
    let units = PlaneUnits::new(MergeTest::Plane { tolerance_texels: 0.5 }, 1.0 / 128.0);
    let image = piecewise(128, &mut Random(77));
    let plane = MergeTest::Plane { tolerance_texels: 0.5 };
    let settings = MergeSettings { merges: 3, test: plane, precision: DepthPrecision::Bits32, units };
    let tree = HybridTree::build(&image, settings).unwrap();
    assert!(tree.shares()[3] > 0.2 && tree.shares()[0] > 0.01, "{:?}", tree.shares());
    for (i, &depth) in image.texels().iter().enumerate() {
        let behind = tree.texel(i as i64 % 128, i as i64 / 128).0 - depth;
        assert!((-1e-6..0.5 / 128.0 + 1e-6).contains(&behind), "{i}: {behind}");
    }
}
