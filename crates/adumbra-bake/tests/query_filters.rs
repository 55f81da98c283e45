//! Look-ups compared tap by tap with the filter's definition, counted one voxel at a time.

use adumbra::grid::vec3::{dot, normalize};
use adumbra::layout::depths::DepthTree;
use adumbra::query::{FixedReceiver, Receiver, receiver};
use adumbra::{Bias, Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, generate};
use adumbra_testing::{Leaf, from_leaves};

fn baked() -> ShadowFile {
    baked_in(FrameChoice::Light)
}

fn baked_in(frame: FrameChoice) -> ShadowFile {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(256)).with(|o| o.frame = frame);
    Bake::with_options(&generate(GeneratedKind::Primitives, 1), &options).in_memory().unwrap()
}

/// The definition: each tap samples the voxel of its texel through which the receiver's plane passes there.
fn by_definition(voxels: &DepthTree, r: &FixedReceiver, filter: Filter) -> u32 {
    let texel = [0, 1].map(|a| r.p_fixed[a].div_euclid(4096));
    let reach = i64::from(filter.width()) / 2;
    let [nx, ny, nz] = voxels.size().map(i64::from);
    let mut lit = 0;
    for y in texel[1] - reach..=texel[1] + reach {
        for x in texel[0] - reach..=texel[0] + reach {
            let along = |a: usize| i64::from(r.gradient[a]) * (4096 * [x, y][a] + 2048 - r.p_fixed[a]);
            let layer = (r.p_fixed[2] + (along(0) + along(1)).div_euclid(256)).div_euclid(4096);
            let inside = (0..nx).contains(&x) && (0..ny).contains(&y) && layer >= 0;
            let k = layer.min(nz - 1);
            lit += u32::from(!inside || voxels.voxel(x as u32, y as u32, k as u32));
        }
    }
    lit
}

#[test]
fn sampler_counts_taps_as_the_definition_does() {
    let file = baked();
    let mut random = Random::for_batch(11, 0);
    let size = file.tree.size().map(f64::from);
    let mut partly_lit = 0;
    for _ in 0..4000 {
        // Slightly beyond the grid on every side.
        let p_grid: [f64; 3] = std::array::from_fn(|a| (random.unit() * 1.2 - 0.1) * size[a]);
        // Up to the steepest gradients allowed, with some along an axis and some flat.
        let steep = [0.0, 0.5, 6.0, 20.0][(random.unit() * 4.0) as usize];
        let gradient = [0, 1].map(|_| steep * (random.unit() - 0.5));
        let fixed = FixedReceiver::new(&Receiver { p_grid, gradient }, file.tree.size());
        for filter in Filter::ALL {
            let sampler = file.sampler(filter);
            let lit = sampler.lit_taps(&fixed);
            assert_eq!(lit, by_definition(&file.tree, &fixed, filter), "{fixed:?} {filter:?}");
            assert_eq!(sampler.successive_lit_taps()(&fixed), lit);
            let answer = sampler.receiver_visibility(&Receiver { p_grid, gradient });
            assert_eq!(answer, lit as f32 / filter.width().pow(2) as f32);
            partly_lit += usize::from(answer > 0.0 && answer < 1.0);
        }
    }
    assert!(partly_lit > 500, "{partly_lit}");
}

/// Leaves of any ranks and slants, in which neighbouring columns have nothing in common, and those of a bake.
#[test]
fn sampler_counts_taps_of_any_leaves_as_the_definition_does() {
    let mut random = Random::for_batch(13, 0);
    let mut below = |n: u32| (random.unit() * f64::from(n)) as u32;
    let leaves: Vec<Leaf> = (0..16)
        .map(|_| {
            let (count, never) = (1 + below(5), below(2) == 1);
            Leaf {
                slant: (below(3) > 0).then(|| [below(256) as u8 as i8, below(256) as u8 as i8]),
                width: 1,
                differences: (0..count).map(|_| below(60)).collect(),
                never,
                ranks: (0..64).map(|_| below(count + 1 + u32::from(never))).collect(),
            }
        })
        .collect();
    let ShadowFile { grid, settings, .. } = baked();
    // The second grid ends before its columns switch.
    for depth in [700, 310] {
        let tree = from_leaves(&leaves, 4, 300, depth).unwrap();
        let file = ShadowFile::new(grid, settings, tree);
        let size = file.tree.size().map(f64::from);
        let mut partly_lit = 0;
        let samplers = Filter::ALL.map(|filter| file.sampler(filter));
        let mut successive = samplers.each_ref().map(|sampler| sampler.successive_lit_taps());
        let mut p_grid = [0.0; 3];
        for step in 0..4000 {
            for a in 0..3 {
                p_grid[a] = match step % 8 {
                    0 => (random.unit() * 1.2 - 0.1) * size[a],
                    _ => p_grid[a] + random.unit() * 6.0 - 3.0,
                };
            }
            let steep = [0.0, 0.5, 6.0, 240.0][(random.unit() * 4.0) as usize];
            let gradient = [0, 1].map(|_| steep * (random.unit() - 0.5));
            let fixed = FixedReceiver::new(&Receiver { p_grid, gradient }, file.tree.size());
            for (sampler, lit_taps) in samplers.iter().zip(&mut successive) {
                let filter = sampler.filter();
                let expected = by_definition(&file.tree, &fixed, filter);
                assert_eq!(sampler.lit_taps(&fixed), expected, "{fixed:?} {filter:?}");
                assert_eq!(lit_taps(&fixed), expected, "successive, {fixed:?} {filter:?}");
                partly_lit += u32::from(expected > 0 && expected < filter.width().pow(2));
            }
        }
        assert!(partly_lit > 500, "{partly_lit}");
    }
}

#[test]
fn successive_look_ups_give_the_samplers_answers_in_any_order() {
    let file = baked();
    let size = file.tree.size().map(f64::from);
    for filter in Filter::ALL {
        let sampler = file.sampler(filter);
        let mut lit_taps = sampler.successive_lit_taps();
        let mut random = Random::for_batch(12, u64::from(filter.width()));
        let mut p_grid = size.map(|n| n / 2.0);
        let mut partly_lit = 0;
        for step in 0..6000 {
            // Steps to neighbours, with occasional leaps, also beyond the grid.
            for a in 0..3 {
                p_grid[a] = match step % 20 {
                    0 => (random.unit() * 1.2 - 0.1) * size[a],
                    _ => p_grid[a] + random.unit() * 2.0 - 1.0,
                };
            }
            let gradient = [random.unit() * 2.0 - 1.0, random.unit() * 2.0 - 1.0];
            let fixed = FixedReceiver::new(&Receiver { p_grid, gradient }, file.tree.size());
            let lit = lit_taps(&fixed);
            assert_eq!(lit, sampler.lit_taps(&fixed), "{fixed:?} {filter:?}");
            partly_lit += u32::from(lit > 0 && lit < filter.width().pow(2));
        }
        assert!(filter == Filter::Nearest || partly_lit > 20, "{partly_lit} {filter:?}");
    }
    // Compares a batch with single look-ups by world points, with and without normals.
    let sampler = file.sampler(Filter::Box9);
    let points: Vec<_> = (0..2000).map(|i| [f64::from(i) * 0.01 - 10.0, 0.0, f64::from(i % 7)]).collect();
    let normals = vec![[0.0, 1.0, 0.0]; points.len()];
    for normals in [None, Some(&normals[..])] {
        let one_by_one: Vec<_> =
            (0..2000).map(|i| sampler.visibility(points[i], normals.map(|n| n[i]))).collect();
        let mut batch = vec![0.5; points.len()];
        sampler.visibilities(&points, normals, &mut batch).unwrap();
        assert_eq!(batch, one_by_one);
    }
}

#[test]
fn filter_from_width_accepts_only_known_widths() {
    assert!(Filter::ALL.into_iter().all(|filter| Filter::try_from(filter.width()) == Ok(filter)));
    assert!([0, 2, 4, 7, 33].into_iter().all(|width| Filter::try_from(width).is_err()));
}

#[test]
fn sampler_answers_any_point() {
    let sampler = baked().sampler(Filter::Box17);
    for p in [[f64::NAN; 3], [f64::INFINITY, 0.0, 0.0], [1e300; 3], [-1e12, 5.0, 0.0]] {
        for normal in [None, Some([0.0; 3]), Some([f64::NAN; 3]), Some([0.0, -1.0, 0.0])] {
            assert_eq!(sampler.visibility(p, normal), 1.0);
        }
    }
}

#[test]
fn bias_moves_a_point_along_its_own_sun_ray() {
    let bias = Bias { constant_texels: 1.5, slope_texels: 0.5, normal_offset_texels: 0.0 };
    // A plane that is level to neither frame.
    let normal = normalize([0.2, 1.0, -0.4]);
    let on_plane = |x: f64, z: f64| [x, -(normal[0] * x + normal[2] * z) / normal[1], z];
    for frame in [FrameChoice::Light, FrameChoice::ObliqueAt(0.3)] {
        let baked = baked_in(frame);
        let p = on_plane(1.0, 2.0);
        let plain = baked.grid.to_grid(p);
        let lifted = receiver(&baked.grid, &bias, p, Some(normal));
        assert!((plain[0] - lifted.p_grid[0]).abs() < 1e-9 && (plain[1] - lifted.p_grid[1]).abs() < 1e-9);
        let [gx, gy] = lifted.gradient;
        let slope = gx.hypot(gy);
        assert!((plain[2] - lifted.p_grid[2] - 1.5 - 0.5 * slope).abs() < 1e-9, "{frame:?}");
        // The plane is the receiver's: a step along it stays on it.
        let beside = baked.grid.to_grid(on_plane(1.4, 1.1));
        let expected = plain[2] + gx * (beside[0] - plain[0]) + gy * (beside[1] - plain[1]);
        assert!((beside[2] - expected).abs() < 1e-9, "{frame:?}");
        if frame == FrameChoice::Light {
            let n_dot_l = dot(normal, baked.grid.sun.towards());
            assert!((slope - (1.0 - n_dot_l * n_dot_l).sqrt() / n_dot_l).abs() < 1e-9);
        }
    }
}

/// A normal offset moves a point to the parallel plane at that distance.
#[test]
fn normal_offset_keeps_its_length_in_either_frame() {
    let bias = Bias { constant_texels: 0.0, slope_texels: 0.0, normal_offset_texels: 0.75 };
    let normal = normalize([0.2, 1.0, -0.4]);
    for frame in [FrameChoice::Light, FrameChoice::ObliqueAt(0.3)] {
        let grid = baked_in(frame).grid;
        let p = [1.0, 0.25, 2.0];
        let lifted = grid.to_world(receiver(&grid, &bias, p, Some(normal)).p_grid);
        for a in 0..3 {
            let expected = p[a] + 0.75 * grid.voxel_size * normal[a];
            assert!((lifted[a] - expected).abs() < 1e-9, "{frame:?}: {lifted:?}");
        }
    }
}

#[test]
fn non_finite_normal_counts_as_no_normal() {
    let baked = baked();
    let mut random = Random::for_batch(5, 0);
    let bias = Bias { normal_offset_texels: 0.5, ..Bias::default() };
    let size = baked.grid.size.map(f64::from);
    let mut shadowed = 0;
    for _ in 0..2000 {
        let p = baked.grid.to_world(std::array::from_fn(|a| random.unit() * size[a]));
        for filter in [Filter::Nearest, Filter::Box9] {
            let sampler = baked.sampler(filter).with_bias(bias).unwrap();
            let without = sampler.visibility(p, None);
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                for normal in [[bad; 3], [bad, 1.0, 0.0], [0.0, 0.8, bad]] {
                    assert_eq!(sampler.visibility(p, Some(normal)), without, "{normal:?} at {p:?}");
                }
            }
            shadowed += usize::from(without < 0.5);
        }
    }
    assert!(shadowed > 200, "{shadowed}");
}
