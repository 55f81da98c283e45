//! Compares level ground under low suns with directly computed shadows of the boxes on it.

use adumbra::query::receiver;
use adumbra::{Filter, Sun};
use adumbra_bake::{BakeOptions, Size};
use adumbra_scene::random::Random;

use super::model::{Model, Point, UP, bake_quietly, scene};

const HALF: f64 = 50.0;

struct Boxes(Vec<[Point; 2]>);

impl Boxes {
    fn random(random: &mut Random) -> Self {
        let mut any = |low: f64, high: f64| low + (high - low) * random.unit();
        let one = |_| {
            let (x, z) = (any(-40.0, 40.0), any(-40.0, 40.0));
            let (width, height, depth) = (any(1.0, 4.0), any(0.5, 4.0), any(1.0, 4.0));
            [[x, -0.5, z], [x + width, height, z + depth]].map(|p| p.map(|c| f64::from(c as f32)))
        };
        Self((0..12).map(one).collect())
    }

    /// Whether the ray from a point in this direction hits a box.
    fn block(&self, from: Point, towards: Point) -> bool {
        self.0.iter().any(|[low, high]| {
            let (mut near, mut far) = (0.0_f64, f64::INFINITY);
            for a in 0..3 {
                let [u, v] = [low, high].map(|side| (side[a] - from[a]) / towards[a]);
                (near, far) = (near.max(u.min(v)), far.min(u.max(v)));
            }
            near <= far
        })
    }

    fn stand_near(&self, p: Point) -> bool {
        self.0.iter().any(|[low, high]| [0, 2].iter().all(|&a| (low[a] - 0.2..high[a] + 0.2).contains(&p[a])))
    }
}

/// Acne and leaks remain rare down to 1°, and a 9 × 9 filter gives what its 81 rays would.
#[test]
fn level_ground_under_a_low_sun_matches_rays() {
    let mut random = Random::for_batch(3, 0);
    let boxes = Boxes::random(&mut random);
    let mut model = Model::default();
    model.level_square(HALF, 0.0);
    for [low, high] in &boxes.0 {
        model.cuboid(*low, *high);
    }
    let scene = scene(&[model]);
    let mut any = || (2.0 * random.unit() - 1.0) * (HALF - 1.0);
    let points: Vec<Point> =
        (0..20_000).map(|_| [any(), 0.0, any()]).filter(|p| !boxes.stand_near(*p)).collect();
    for elevation in [10.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0] {
        let sun = Sun::from_angles(37.0, elevation).unwrap();
        let towards = sun.towards();
        let baked = bake_quietly(&scene, &BakeOptions::new(sun, Size::Resolution(2048)));
        let (single, filtered) = (baked.sampler(Filter::Nearest), baked.sampler(Filter::Box9));
        let (mut acne, mut leak) = (0, 0);
        let (mut from_rays, mut from_truth, mut compared) = (0.0, 0.0, 0.0);
        for (n, &p) in points.iter().enumerate() {
            let lit = !boxes.block(p, towards);
            let found = single.visibility(p, Some(UP)) > 0.5;
            acne += usize::from(lit && !found);
            leak += usize::from(!lit && found);
            if n % 8 == 0 {
                let soft = f64::from(filtered.visibility(p, Some(UP)));
                let unbiased =
                    adumbra::Bias { constant_texels: 0.0, slope_texels: 0.0, normal_offset_texels: 0.0 };
                let r = receiver(&baked.grid, &unbiased, p, Some(UP));
                let mut seen = 0;
                for tap in 0..81 {
                    let center =
                        [0, 1].map(|a| r.p_grid[a].floor() + 0.5 + f64::from([tap % 9, tap / 9][a]) - 4.0);
                    let [dx, dy] = [0, 1].map(|a| center[a] - r.p_grid[a]);
                    let depth = r.p_grid[2] + r.gradient[0] * dx + r.gradient[1] * dy;
                    let on_ground = baked.grid.to_world([center[0], center[1], depth]);
                    seen += usize::from(!boxes.block(on_ground, towards));
                }
                from_rays += (soft - seen as f64 / 81.0).abs();
                from_truth += (soft - f64::from(u8::from(lit))).abs();
                compared += 1.0;
            }
        }
        let share = |n: usize| n as f64 / points.len() as f64;
        let (from_rays, from_truth) = (from_rays / compared, from_truth / compared);
        println!(
            "{elevation}°: acne {:.4}, leak {:.4}; 9 × 9 from its rays {from_rays:.4}, from hard shadows {from_truth:.4}",
            share(acne),
            share(leak)
        );
        assert!(
            share(acne + leak) <= 0.005,
            "{elevation}°: {acne} with acne, {leak} leak of {}",
            points.len()
        );
        assert!(from_rays <= 0.02, "{elevation}°: a filter is {from_rays} from its rays");
    }
}
