//! A lower surface close behind an upper one: nothing of it is lit once the gap between them exceeds the
//! bias.

use adumbra::{Bias, Sun};
use adumbra_bake::{BakeOptions, FrameChoice, Size};
use adumbra_scene::random::Random;

use super::model::{Model, Point, bake_quietly, lit_on_ground, scene};

const VOXEL: f64 = 0.1;
/// Gaps along the light in excess of the bias, voxels.
const BEYOND_BIAS: [f64; 8] = [0.05, 0.3, 0.6, 1.0, 1.5, 2.5, 4.0, 6.0];

/// Checks that no point on a floor is lit in the shadow of what `upper` adds above it, for gaps from the bias
/// to 10 voxels, slopes of level ground to the light from 0 to 8, and three offsets of the scene along the
/// light.
fn assert_dark(upper: impl Fn(&mut Model, f64)) {
    let mut random = Random::for_batch(7, 0);
    let mut any = |low: f64, high: f64| low + (high - low) * random.unit();
    for slope in [0.0, 0.76, 2.0, 4.0, 8.0_f64] {
        let cosine = 1.0 / slope.hypot(1.0);
        let sun = Sun::from_direction([slope, 1.0, 0.0]).unwrap();
        // Gaps and biases are in voxels along the light.
        let options = BakeOptions::new(sun, Size::VoxelSize(VOXEL)).with(|o| o.frame = FrameChoice::Light);
        let bias = Bias::default().along_light(slope);
        for gap in BEYOND_BIAS.map(|beyond| bias + beyond).into_iter().chain([10.0]) {
            for phase in [0.0, 0.27, 0.61] {
                let mut model = Model::default();
                // Move the scene, not the grid. Vertices are stored as 32-bit floats.
                let floor = f64::from((phase * VOXEL / cosine) as f32);
                model.level_square(5.0, floor);
                upper(&mut model, floor + gap * VOXEL * cosine);
                let baked = bake_quietly(&scene(&[model]), &options);
                // More than half a texel from the rim: a texel spans almost a metre of the floor when the sun
                // is lowest.
                let points: Vec<Point> = (0..300).map(|_| [any(-2.0, 1.3), floor, any(-2.5, 2.5)]).collect();
                let lit = lit_on_ground(&baked, &points);
                assert_eq!(lit, 0, "slope {slope}, gap {gap}, bias {bias}, phase {phase}: lit points");
            }
        }
    }
}

#[test]
fn open_quad_shadows_the_quad_behind_it() {
    assert_dark(|model, height| model.level_square(3.0, height));
}

#[test]
fn slab_shadows_the_quad_behind_it() {
    assert_dark(|model, height| model.cuboid([-3.0, height, -3.0], [3.0, height + 1.0, 3.0]));
}

#[test]
fn paper_thin_slab_shadows_the_quad_behind_it() {
    assert_dark(|model, height| model.cuboid([-3.0, height, -3.0], [3.0, height + 0.002, 3.0]));
}
