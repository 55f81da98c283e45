//! The grid parameters for shaders must be exact on the largest grids.

use adumbra::gpu::GridParameters;
use adumbra::query::{FIXED_ONE, MAX_FIXED_SIDE};
use adumbra::{Bounds, Frame, LightExtent, LightGrid, Sun};
use adumbra_scene::random::Random;

/// Computes what core/grid.wgsl computes, in f32: the sum of the whole part and the remainder, in voxels.
fn shader(t: &GridParameters, p: [f32; 3]) -> [f64; 3] {
    let steps = p.map(|c| (c * t.steps_per_world).round_ties_even());
    let below: [f32; 3] = std::array::from_fn(|a| p[a] - steps[a] * t.step_world);
    let n = steps.map(|s| s as i32);
    let axes = t.axes;
    std::array::from_fn(|a| {
        let products = t.steps.map(|step| step[a]).into_iter().zip(n).map(|(s, n)| s.wrapping_mul(n));
        let whole = products.fold(t.anchor_fixed[a], i32::wrapping_add);
        let left_over = steps[0] * t.rests[0][a] + steps[1] * t.rests[1][a] + steps[2] * t.rests[2][a];
        let low = axes[a][0] * below[0] + axes[a][1] * below[1] + axes[a][2] * below[2];
        let rest = t.anchor_remainder[a] + left_over + t.voxels_per_world * low;
        f64::from(whole) / f64::from(FIXED_ONE) + f64::from(rest)
    })
}

#[test]
fn gpu_grid_loses_nothing_on_the_largest_grids() {
    let sun = Sun::from_angles(217.0, 34.0).unwrap();
    let bounds = Bounds { min: [-700.0, -3.0, 200.0], max: [900.0, 150.0, 1900.0] };
    let mut random = Random::new(3, 0);
    let oblique = Frame::Oblique { yaw_radians: 0.4 };
    for (frame, resolution) in
        [(Frame::Light, 1024.0), (Frame::Light, 16384.0), (Frame::Light, 262_144.0), (oblique, 262_144.0)]
    {
        let mut extent = LightExtent::in_frame(&sun, frame);
        extent.add_box(&bounds);
        let grid = LightGrid::covering(sun, &extent, extent.longest_side() / resolution);
        for anchor in [[100.0, 75.0, 1050.0], [-700.0, 1.7, 1900.0]] {
            let t = GridParameters::new(&grid, anchor).unwrap();
            let mut worst = 0.0_f64;
            for _ in 0..20_000 {
                let p: [f32; 3] = std::array::from_fn(|a| {
                    let share = random.unit();
                    (bounds.min[a] + share * (bounds.max[a] - bounds.min[a]) - anchor[a]) as f32
                });
                let exact = grid.to_grid(std::array::from_fn(|a| anchor[a] + f64::from(p[a])));
                let found = shader(&t, p);
                worst = (0..3).map(|a| (found[a] - exact[a]).abs()).fold(worst, f64::max);
            }
            assert!(worst < 1e-5, "{resolution}: {worst} voxels");
        }
    }
}

#[test]
fn gpu_grid_too_long_for_fixed_point_is_refused() {
    let sun = Sun::from_angles(217.0, 34.0).unwrap();
    let side = MAX_FIXED_SIDE + 1;
    let grid = LightGrid::new(sun, Frame::Light, 1.0, [0.0; 3], [8, 8, side]);
    let refused = GridParameters::new(&grid, [0.0; 3]);
    assert_eq!(refused.unwrap_err().value, side.to_string());
}
