//! Look-ups in a file, compared with a count of its lit voxels, tap by tap, by the rules of the
//! specification.

use std::thread;

use adumbra::layout::depths::page::{Page, bundles, page_dims};
use adumbra::layout::depths::{DepthTree, NEVER, TreeBuilder};
use adumbra::query::MAX_FIXED_SIDE;
use adumbra::{Bias, Error, Filter, PathSampler, PointVisibility, RangeField, Sampler, ShadowFile};
use adumbra_scene::random::Random;
use adumbra_testing::{Leaf, from_leaves, overhead_grid, placements, settings_for, vectors};

/// A file of each shape: both frames, odd sizes, wide differences, slanted leaves, a low sun, many pages.
const NAMES: [&str; 7] =
    ["sphere", "upright", "upright_turned_low", "odd_sizes", "cliff", "low_sun_tall", "many_pages"];

/// A bias of which every term is in use.
const BIAS: Bias = Bias { constant_texels: 0.7, slope_texels: 1.3, normal_offset_texels: 0.4 };

type Point = ([f64; 3], Option<[f64; 3]>);

fn file(name: &str) -> ShadowFile {
    ShadowFile::read(vectors(&format!("valid/{name}_depths.adumbra"))).expect("a valid file")
}

/// Returns the visibility of a point: the share of lit voxels among the taps, each looked up on its own.
fn counted(file: &ShadowFile, bias: Bias, filter: Filter, (point, normal): Point) -> f32 {
    let (grid, size) = (&file.grid, file.grid.size.map(i64::from));
    let mut at = grid.to_grid(point);
    let (mut slopes, mut slope) = ([0.0; 2], 0.0);
    if let Some(normal) = normal.filter(|n| n.iter().all(|c| c.is_finite())) {
        let n = grid.normal_to_grid(normal);
        let t = (n[0] * n[0] + n[1] * n[1]).sqrt();
        let c = n[2].abs().max(t / 120.0);
        if c > 0.0 {
            let d = if n[2] > 0.0 { -c } else { c };
            slopes = [n[0] / d, n[1] / d];
            slope = (t / c).min(9.95);
        }
        let off = grid.direction_to_grid(normal);
        at = [0, 1, 2].map(|a| at[a] + off[a] * bias.normal_offset_texels);
    }
    at[2] -= bias.constant_texels + bias.slope_texels * slope;
    if !at.iter().all(|c| c.is_finite()) {
        return 1.0;
    }
    let fixed = |a: usize| ((at[a] * 4096.0).floor() as i64).clamp(-4096 << 12, (size[a] + 4096) << 12);
    let p = [0, 1, 2].map(fixed);
    let s = slopes.map(|s| ((256.0 * s + 0.5).floor() as i64).clamp(-30_720, 30_720));
    let reach = i64::from(filter.width() / 2);
    let taps = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
    let is_lit = |[dx, dy]: [i64; 2]| {
        let [x, y] = [(p[0] >> 12) + dx, (p[1] >> 12) + dy];
        let sum = s[0] * (4096 * x + 2048 - p[0]) + s[1] * (4096 * y + 2048 - p[1]);
        let layer = ((p[2] << 8) + sum) >> 20;
        let outside = !(0..size[0]).contains(&x) || !(0..size[1]).contains(&y) || layer < 0;
        outside || file.tree.voxel(x as u32, y as u32, layer.min(size[2] - 1) as u32)
    };
    taps.filter(|&tap| is_lit(tap)).count() as f32 / (filter.width() * filter.width()) as f32
}

/// Returns points in and around a file's grid, every third without a normal, and half of them near where
/// their column switches.
fn points(file: &ShadowFile, count: usize, random: &mut Random) -> Vec<Point> {
    let size = file.grid.size.map(f64::from);
    let mut point = |number: usize| {
        let mut any = |low: f64, high: f64| low + (high - low) * random.unit();
        let mut at = size.map(|n| any(-6.0, n + 6.0));
        let inside = at[0] >= 0.0 && at[0] < size[0] && at[1] >= 0.0 && at[1] < size[1];
        if number.is_multiple_of(2) && inside {
            let depth = file.tree.value(at[0] as u32, at[1] as u32);
            at[2] = f64::from(depth).min(size[2]) + any(-4.0, 6.0);
        }
        let normal = match number % 3 {
            0 => None,
            1 => Some([0.0, 1.0, 0.0]),
            _ => Some([any(-1.0, 1.0), any(-1.0, 1.0), any(-1.0, 1.0)]),
        };
        let unit = normal.map(|n| n.map(|c| c / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()));
        (file.grid.to_world(at), unit)
    };
    (0..count).map(&mut point).collect()
}

/// Compares look-ups with the count, and returns how many points are partly lit.
fn check(file: &ShadowFile, sampler: &Sampler, points: &[Point]) -> usize {
    let (bias, filter) = (sampler.bias(), sampler.filter());
    let visibility = |point: &Point| {
        let found = sampler.visibility(point.0, point.1);
        assert_eq!(found, counted(file, bias, filter, *point), "{filter:?} at {point:?}");
        found
    };
    points.iter().map(visibility).filter(|v| (0.001..0.999).contains(v)).count()
}

#[test]
fn every_filter_counts_the_lit_voxels_of_its_taps() {
    let mut random = Random::new(5, 0);
    for name in NAMES {
        let file = file(name);
        let points = points(&file, 2000, &mut random);
        for filter in Filter::ALL {
            let sampler = file.sampler(filter);
            assert_eq!((sampler.filter(), sampler.bias()), (filter, file.settings.bias));
            let partly = check(&file, &sampler, &points);
            assert_eq!(partly > 50, filter != Filter::Nearest, "{name}, {filter:?}: {partly} partly lit");
            check(&file, &sampler.with_bias(BIAS).unwrap(), &points);
        }
    }
}

/// Separates points and normals into the lists that batch look-ups take.
fn lists(points: &[Point]) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    points.iter().map(|(point, normal)| (*point, normal.unwrap_or([0.0, 1.0, 0.0]))).unzip()
}

#[test]
fn batch_look_ups_match_single_look_ups() {
    let mut random = Random::new(6, 0);
    for name in NAMES {
        let file = file(name);
        let mut all = points(&file, 1000, &mut random);
        // Sort, so that neighbours share blocks.
        all.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
        let (points, normals) = lists(&all);
        for filter in Filter::ALL {
            let sampler = file.sampler(filter);
            for normals in [Some(&normals[..]), None] {
                let mut out = vec![-1.0; points.len()];
                sampler.visibilities(&points, normals, &mut out).unwrap();
                for (i, (&found, &point)) in out.iter().zip(&points).enumerate() {
                    assert_eq!(found, sampler.visibility(point, normals.map(|n| n[i])), "{name} {point:?}");
                }
                let look_ups: &dyn PointVisibility = &sampler;
                assert_eq!(look_ups.visibilities(&points, normals), out);
                assert_eq!(look_ups.visibility(points[0], normals.map(|n| n[0])), out[0]);
            }
        }
    }
}

/// Checks that lists of different lengths are refused and that nothing is written.
fn refuses_other_lengths(
    look_up: impl Fn(&[[f64; 3]], Option<&[[f64; 3]]>, &mut [f32]) -> adumbra::Result<()>,
) {
    let (points, up) = ([[0.0; 3]; 3], [[0.0, 1.0, 0.0]; 4]);
    for (normals, results, wrong) in [(3, 2, 2), (3, 4, 4), (2, 3, 2), (4, 3, 4)] {
        let mut out = vec![-1.0; results];
        let Err(Error::Range(error)) = look_up(&points, Some(&up[..normals]), &mut out) else {
            panic!("{normals} normals, {results} results")
        };
        assert_eq!((error.field, error.value), (RangeField::PointCount, format!("{wrong} for 3 points")));
        assert!(out.iter().all(|&v| v == -1.0));
    }
    assert!(look_up(&points, None, &mut [0.0; 2]).is_err());
    look_up(&[], Some(&[]), &mut []).unwrap();
}

#[test]
fn rejects_lists_of_different_lengths() {
    let sampler = file("sphere").sampler(Filter::Box5);
    refuses_other_lengths(|points, normals, out| sampler.visibilities(points, normals, out));
}

#[cfg(feature = "rayon")]
#[test]
fn parallel_look_ups_match_serial_look_ups() {
    let file = file("upright_turned_low");
    let (points, normals) = lists(&points(&file, 20_000, &mut Random::new(7, 0)));
    let sampler = file.sampler(Filter::Box9);
    for normals in [Some(&normals[..]), None] {
        let [mut one, mut all] = [(); 2].map(|()| vec![-1.0; points.len()]);
        sampler.visibilities(&points, normals, &mut one).unwrap();
        sampler.par_visibilities(&points, normals, &mut all).unwrap();
        assert_eq!(one, all);
    }
    refuses_other_lengths(|points, normals, out| sampler.par_visibilities(points, normals, out));
}

#[test]
fn placed_look_ups_match_unplaced_look_ups() {
    let mut random = Random::new(9, 0);
    for name in NAMES {
        let file = file(name);
        let points = points(&file, 300, &mut random);
        for filter in [Filter::Nearest, Filter::Box5] {
            let sampler = file.sampler(filter).with_bias(BIAS).unwrap();
            for (place, placement) in placements() {
                let placed = sampler.clone().placed(&placement);
                for (point, normal) in &points {
                    let in_app = placement.to_world(*point);
                    let turned = normal.map(|n| placement.direction_to_world(n));
                    let expected = sampler.visibility(*point, *normal);
                    assert_eq!(placed.visibility(in_app, turned), expected, "{name}, {place}: {point:?}");
                }
            }
        }
        // Two placements in succession, and look-ups between the keys of a path.
        let [(_, first), .., (_, second)] = placements();
        let towards_sun = file.grid.sun.towards();
        let path = PathSampler::new([&file, &file], towards_sun, Filter::Box5).unwrap();
        let sampler = file.sampler(Filter::Box5);
        let twice = sampler.clone().placed(&first).placed(&second);
        let path_twice = path.clone().placed(&first).placed(&second);
        for (point, normal) in &points {
            let in_app = second.to_world(first.to_world(*point));
            let turned = normal.map(|n| second.direction_to_world(first.direction_to_world(n)));
            assert_eq!(
                twice.visibility(in_app, turned),
                sampler.visibility(*point, *normal),
                "{name}: {point:?}"
            );
            assert_eq!(
                path_twice.look_up(in_app, turned),
                path.look_up(*point, *normal),
                "{name}: {point:?}"
            );
        }
    }
}

#[test]
fn sampler_outlives_its_file_and_works_across_threads() {
    let file = file("sphere");
    let points = points(&file, 100, &mut Random::new(8, 0));
    let expected: Vec<f32> =
        points.iter().map(|p| counted(&file, file.settings.bias, Filter::Box3, *p)).collect();
    let sampler = file.sampler(Filter::Box3);
    drop(file);
    let look_up = |sampler: &Sampler| -> Vec<f32> {
        points.iter().map(|(point, normal)| sampler.visibility(*point, *normal)).collect()
    };
    thread::scope(|scope| {
        let moved = sampler.clone();
        let of_a_clone = scope.spawn(move || look_up(&moved));
        let shared = scope.spawn(|| look_up(&sampler));
        assert_eq!([of_a_clone.join().unwrap(), shared.join().unwrap()], [expected.clone(), expected]);
    });
}

#[test]
fn point_that_is_not_finite_is_lit() {
    let file = file("sphere");
    let dark = file.grid.to_world([31.5, 31.5, 63.0]);
    for filter in Filter::ALL {
        let sampler = file.sampler(filter);
        assert_eq!(sampler.visibility(dark, None), 0.0);
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for a in 0..3 {
                let (mut point, mut normal) = (dark, [0.0, 1.0, 0.0]);
                point[a] = value;
                for normal in [None, Some([0.0, 1.0, 0.0])] {
                    assert_eq!(sampler.visibility(point, normal), 1.0, "{point:?}");
                }
                // A normal that is not finite counts as none.
                normal[a] = value;
                assert_eq!(sampler.visibility(dark, Some(normal)), 0.0, "{normal:?}");
            }
        }
    }
}

#[test]
fn bias_out_of_range_is_refused() {
    let sampler = file("sphere").sampler(Filter::Box5);
    for value in [17.0, -0.1, f64::NAN] {
        let terms = [
            Bias { constant_texels: value, ..BIAS },
            Bias { slope_texels: value, ..BIAS },
            Bias { normal_offset_texels: value, ..BIAS },
        ];
        for bias in terms {
            let Err(Error::Range(error)) = sampler.clone().with_bias(bias) else { panic!("{bias:?}") };
            assert_eq!((error.field, error.value), (RangeField::BiasTerm, value.to_string()));
        }
    }
    let most = Bias { constant_texels: 16.0, slope_texels: 0.0, normal_offset_texels: 16.0 };
    assert_eq!(sampler.with_bias(most).unwrap().bias(), most);
}

#[test]
fn filter_converts_from_valid_widths_only() {
    for filter in Filter::ALL {
        assert_eq!(Filter::try_from(filter.width()), Ok(filter));
    }
    for width in [0, 2, 4, 19] {
        assert_eq!(Filter::try_from(width).unwrap_err().field, RangeField::FilterWidth);
    }
}

/// Returns a file of this quadtree, with the sun overhead.
fn file_of(tree: DepthTree) -> ShadowFile {
    let grid = overhead_grid([0.0, 8.0, 0.0], tree.size());
    ShadowFile::new(grid, settings_for(&grid), tree)
}

#[test]
fn grids_too_long_for_32_bits_match_the_count() {
    let leaf = |differences: Vec<u32>, seed: u32| Leaf {
        width: 2,
        ranks: (0..64).map(|column| (column * seed / 8) % 4).collect(),
        differences,
        never: true,
        ..Leaf::default()
    };
    let leaves: Vec<Leaf> = (0..64).map(|at| leaf(vec![3 + at, 2 * at + 1], 5 + at)).collect();
    let deep = from_leaves(&leaves, 8, MAX_FIXED_SIDE - 50, MAX_FIXED_SIDE + 200).unwrap();
    let mut wide = TreeBuilder::new([MAX_FIXED_SIDE + 512, 8, 48], Vec::new());
    for [x, y] in bundles(page_dims([MAX_FIXED_SIDE + 512, 8, 48])) {
        let base = |slot: u32| if slot.is_multiple_of(5) { NEVER } else { 7 * (4 * x + slot) % 40 };
        wide.add([x, y], &std::array::from_fn(|slot| Page::uniform(base(slot as u32))));
    }
    let wide = wide.finish().unwrap();
    let mut random = Random::new(9, 0);
    for file in [file_of(deep), file_of(wide)] {
        let points = points(&file, 3000, &mut random);
        for filter in Filter::ALL {
            let sampler = file.sampler(filter);
            let partly = check(&file, &sampler, &points);
            assert_eq!(partly > 50, filter != Filter::Nearest, "{filter:?}: {partly} partly lit");
            let (points, normals) = lists(&points);
            let mut out = vec![0.0; points.len()];
            sampler.visibilities(&points, Some(&normals), &mut out).unwrap();
            for (i, &found) in out.iter().enumerate() {
                assert_eq!(found, sampler.visibility(points[i], Some(normals[i])), "{:?}", points[i]);
            }
        }
    }
}
