//! The march through a file's depths, compared with a march that skips no blocks, and with look-ups at the
//! file's own sun.

use adumbra::query::{
    EDGE_VOXELS, FIXED_BITS, FixedReceiver, MarchSlope, Marched, SLOPE_BITS, march, receiver,
};
use adumbra::{Bias, Filter, MAX_SLOPE, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, generate};
use adumbra_testing::overhead_grid;

fn city(frame: FrameChoice) -> ShadowFile {
    let sun = Sun::from_angles(130.0, 35.0).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(1024)).with(|o| {
        o.levels = 1;
        o.frame = frame;
    });
    Bake::with_options(&generate(GeneratedKind::City, 3), &options).in_memory().unwrap()
}

#[test]
fn bias_follows_the_angle_between_the_surface_and_the_ray() {
    let grid = overhead_grid([0.0; 3], [64; 3]);
    let bias = Bias { constant_texels: 0.0, slope_texels: 1.0, normal_offset_texels: 0.0 };
    let slope = MarchSlope { v_fixed: [1 << SLOPE_BITS, 0] };
    // The sun is 45° high towards +X: the first surface faces it, and it grazes the second.
    for (normal, rise) in [([1.0, 1.0, 0.0], 0.5), ([1.0, -1.0, 0.0], MAX_SLOPE), ([0.0, 1.0, 0.0], 0.0)] {
        let start = slope.start(&grid, &bias, [16.0, -32.0, 8.0], Some(normal));
        let expected = [16.0 + rise, 8.0, 32.0 - rise].map(|c| (c * f64::from(1 << FIXED_BITS)) as i64);
        assert_eq!(start, expected, "{normal:?}");
    }
}

/// Random points in and around a file's grid.
fn points(file: &ShadowFile, count: usize) -> Vec<[f64; 3]> {
    let mut random = Random::new(5, 0);
    (0..count)
        .map(|_| {
            let at = file.grid.size.map(|n| (1.1 * random.unit() - 0.05) * f64::from(n));
            file.grid.to_world(at)
        })
        .collect()
}

#[test]
fn march_equals_look_up_at_the_files_own_sun() {
    for frame in [FrameChoice::Light, FrameChoice::Oblique] {
        let file = city(frame);
        let (grid, bias) = (&file.grid, file.settings.bias);
        let slope = MarchSlope::new(grid, file.sun().towards()).unwrap();
        assert_eq!(slope.v_fixed, [0, 0]);
        let sampler = file.sampler(Filter::Nearest);
        let mut dark = 0;
        for p in points(&file, 50_000) {
            let fixed = FixedReceiver::new(&receiver(grid, &bias, p, None), grid.size);
            let start = slope.start(grid, &bias, p, None);
            let marched = march(file.tree.words(), slope, start);
            assert_eq!(start, fixed.p_fixed);
            assert_eq!(
                marched,
                if sampler.lit_taps(&fixed) == 1 { Marched::Clear } else { Marched::Blocked }
            );
            dark += u32::from(marched == Marched::Blocked);
        }
        assert!(dark > 5000, "{dark}");
    }
}

/// The march column by column, in floating point.
fn reference(file: &ShadowFile, v: [f64; 2], start: [f64; 3]) -> Marched {
    let tree = file.tree.words();
    let [nx, ny, nz] = tree.size.map(f64::from);
    let [mut x, mut y, mut z] = start;
    z = z.min(nz - 1e-9);
    let mut column = [x.floor(), y.floor()];
    let depth = z;
    let (mut through, mut behind, mut lit_from) = (false, None, f64::INFINITY);
    let end = |through: bool, hidden: f64| {
        let hidden_rise = (hidden * f64::from(1 << FIXED_BITS)) as u32;
        if through { Marched::Unknown { hidden_rise } } else { Marched::Clear }
    };
    loop {
        let [i, j] = column;
        if z < 0.0 || !(0.0..nx).contains(&i) || !(0.0..ny).contains(&j) {
            return end(through, lit_from.min(depth - z).min(depth));
        }
        let value = f64::from(tree.value(i as u32, j as u32));
        let rise_to = |c: f64, v: f64, column: f64| match v {
            0.0 => f64::INFINITY,
            v if v > 0.0 => (column + 1.0 - c) / v,
            v => (column - c) / v,
        };
        let [along_x, along_y] = [rise_to(x, v[0], i), rise_to(y, v[1], j)];
        let rise = along_x.min(along_y).max(0.0);
        if z >= value {
            if z - rise < value {
                return Marched::Blocked;
            }
            through = true;
            behind = Some(value);
        } else {
            if behind.is_some_and(|surface| z - surface < f64::from(EDGE_VOXELS)) {
                return Marched::Blocked;
            }
            behind = None;
            lit_from = lit_from.min(depth - z);
        }
        if rise.is_infinite() {
            return end(through, lit_from.min(depth));
        }
        (x, y, z) = (x + rise * v[0], y + rise * v[1], z - rise);
        if along_x <= along_y {
            column[0] += v[0].signum();
        } else {
            column[1] += v[1].signum();
        }
    }
}

#[test]
fn skipping_blocks_matches_march_column_by_column() {
    for frame in [FrameChoice::Light, FrameChoice::Oblique] {
        let file = city(frame);
        let mut random = Random::new(6, 0);
        let mut counts = [0; 3];
        let (mut differing, mut hidden_rays) = (0, 0);
        for (n, p) in points(&file, 20_000).into_iter().enumerate() {
            let steep = [0.02, 0.3, 3.0, 40.0][n % 4];
            let v = [0; 2].map(|_| steep * (random.unit() - 0.5));
            let v_fixed = v.map(|c| (c * 65536.0) as i32);
            let v = v_fixed.map(|c| f64::from(c) / 65536.0);
            let grid_p = file.grid.to_grid(p);
            let fixed = grid_p.map(|c| (c * f64::from(1 << FIXED_BITS)).floor() as i64);
            let start = fixed.map(|c| c as f64 / f64::from(1 << FIXED_BITS));
            let found = march(file.tree.words(), MarchSlope { v_fixed }, fixed);
            let expected = reference(&file, v, start);
            let (kind, hidden) = kind_and_rise(found);
            let (expected_kind, expected_hidden) = kind_and_rise(expected);
            // Borders are met up to a few 4096ths later, as rises are rounded.
            let is_same = kind == expected_kind && hidden.abs_diff(expected_hidden) <= 1 << FIXED_BITS;
            differing += u32::from(!is_same);
            counts[kind] += 1;
            hidden_rays += u32::from(hidden > 0);
        }
        println!(
            "{frame:?}: blocked, clear, unknown {counts:?}; {differing} differ; {hidden_rays} begin hidden"
        );
        assert!(counts.iter().all(|&count| count > 300) && hidden_rays > 100, "{counts:?}, {hidden_rays}");
        // A ray through the corner of a column may pass either side.
        assert!(differing * 500 <= 20_000, "{differing} of 20,000 differ");
    }
}

/// Returns 0 for blocked, 1 for clear, 2 for unknown, and the rise up to which the ray is hidden.
fn kind_and_rise(marched: Marched) -> (usize, u32) {
    match marched {
        Marched::Blocked => (0, 0),
        Marched::Clear => (1, 0),
        Marched::Unknown { hidden_rise } => (2, hidden_rise),
    }
}

#[test]
fn rays_that_are_hidden_from_both_keys_for_long_are_dark() {
    let unknown = |voxels: u32| Marched::Unknown { hidden_rise: (voxels << FIXED_BITS) + 5 };
    for (first, other, dark_after, is_lit) in [
        (Marched::Blocked, Marched::Clear, 1, false),
        (Marched::Clear, Marched::Blocked, 1, true),
        (unknown(90), Marched::Blocked, 0, false),
        (unknown(90), Marched::Clear, 10, true),
        (unknown(90), unknown(20), 0, true),
        (unknown(90), unknown(20), 21, true),
        (unknown(90), unknown(20), 20, false),
        (unknown(19), unknown(90), 20, true),
    ] {
        assert_eq!(first.is_lit(|| other, dark_after), is_lit, "{first:?}, {other:?}, {dark_after}");
    }
}
