//! Floors under solids with uneven tops: neighbouring columns begin at different depths, but all of them are
//! dark below.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use adumbra::Sun;
use adumbra_bake::{BakeOptions, ColumnBuilder, Size};
use adumbra_scene::random::Random;

use super::model::{Model, Point, bake_quietly, lit_on_ground, scene};

const VOXEL: f64 = 0.1;

/// Checks that at most one in a thousand of these points is lit, for both builders and several switch limits.
fn assert_dark(model: Model, resolution: u64, points: &[Point], what: &str) {
    let scene = scene(&[model]);
    let overhead = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    for switch_within_voxels in [0, 2, 8] {
        for builder in [ColumnBuilder::Fast, ColumnBuilder::Plain] {
            let options = BakeOptions::new(overhead, Size::Resolution(resolution)).with(|o| {
                o.switch_within_voxels = switch_within_voxels;
                o.builder = builder;
            });
            let lit = lit_on_ground(&bake_quietly(&scene, &options), points);
            let of = points.len();
            assert!(
                lit * 1000 <= of,
                "{what}, {builder:?}, within {switch_within_voxels}: {lit} of {of} are lit"
            );
        }
    }
}

/// Steep solid cones over a floor. The parameters are the slope of their sides, and the gap to the floor and
/// height in voxels.
#[test]
fn floor_under_spikes_is_dark() {
    let mut random = Random::for_batch(1, 0);
    for (slope, gap, height) in [
        (10.0, 5.0, 55.0),
        (10.0, 5.0, 56.0),
        (10.0, 5.5, 110.0),
        (5.0, 3.0, 55.0),
        (5.0, 3.2, 58.0),
        (10.0, 4.0, 30.0),
        (2.0, 1.9, 60.0),
        (3.0, 2.3, 58.0),
        (10.0, 5.0, 400.0),
    ] {
        const SIDES: usize = 16;
        const ACROSS: usize = 3;
        let mut model = Model::default();
        model.level_square(12.8, 0.0);
        let mut points = Vec::new();
        let [height, gap] = [height * VOXEL, gap * VOXEL];
        let radius = height / slope;
        for n in 0..ACROSS * ACROSS {
            let [x, z] = [n / ACROSS, n % ACROSS].map(|c| 25.6 * ((c as f64 + 0.5) / ACROSS as f64 - 0.5));
            let rim = |side: usize| {
                let around = TAU * (side % SIDES) as f64 / SIDES as f64;
                [x + radius * around.cos(), gap, z + radius * around.sin()]
            };
            for side in 0..SIDES {
                model.triangle([rim(side + 1), rim(side), [x, gap + height, z]]);
                model.triangle([rim(side), rim(side + 1), [x, gap, z]]);
            }
            // A texel's diagonal inside the rim.
            let reach = radius * (PI / SIDES as f64).cos() - 1.5 * VOXEL;
            points.extend((0..150).map(|_| {
                let (around, away) = (TAU * random.unit(), reach.max(0.0) * random.unit().sqrt());
                [x + away * around.cos(), 0.0, z + away * around.sin()]
            }));
        }
        assert_dark(model, 256, &points, &format!("cones of slope {slope}, gap {gap} m, height {height} m"));
    }
}

/// A slab with a sawtooth top. The parameters are the height of the teeth, their pitch, the thickness below
/// them and the gap to the floor, in voxels. A post of several heights shifts the grid along the light.
fn teeth_are_dark(teeth: &[(f64, f64, f64, f64)], posts: Range<u32>, count: usize) {
    let mut random = Random::for_batch(2, 0);
    for &(teeth, pitch, thickness, gap) in teeth {
        for post in posts.clone() {
            let mut model = Model::default();
            model.level_square(6.4, 0.0);
            let bottom = gap * VOXEL;
            let valleys = bottom + thickness * VOXEL;
            model.toothed_bar(
                [-5.0, 5.0],
                [bottom, valleys, valleys + teeth * VOXEL],
                [-5.0, 5.0],
                pitch * VOXEL,
            );
            model.cuboid([-6.4, 0.0, -6.4], [-6.1, f64::from(post) * VOXEL, -6.1]);
            let mut any = || 9.2 * (random.unit() - 0.5);
            let points: Vec<Point> = (0..count).map(|_| [any(), 0.0, any()]).collect();
            assert_dark(
                model,
                128,
                &points,
                &format!("teeth of {teeth}, pitch {pitch}, gap {gap}, post {post}"),
            );
        }
    }
}

#[test]
fn floor_under_some_teeth_is_dark() {
    teeth_are_dark(&[(5.0, 1.37, 1.0, 4.5), (3.0, 1.5, 0.6, 2.4)], 15..17, 200);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn floor_under_teeth_is_dark() {
    let teeth = [(5.0, 1.37, 1.0, 4.5), (5.0, 1.1, 0.5, 5.5), (3.0, 1.5, 0.6, 2.4), (4.0, 2.1, 0.6, 2.6)];
    teeth_are_dark(&teeth, 15..24, 1000);
}
