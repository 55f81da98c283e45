//! A grid of five by five spheres, alternately resting on y = 0 and floating, all instances of one mesh. The
//! triangle count matches the spheres of Li, Yang, Zhao and Chen, *Hybrid-resolution shadow map*, 2016.

use crate::generate::shapes::MeshBuilder;
use crate::generate::{Placement, Scene, Stage};
use crate::random::Random;

/// Number of spheres along each side.
const COUNT: u32 = 5;
/// Spacing of the spheres, metres.
const PITCH: f64 = 3.0;
/// Segments around and rings from pole to pole: 2 · 24 · (11 - 1) = 480 triangles.
const GRID: [u32; 2] = [24, 11];

pub(super) fn generate(seed: u64) -> Scene {
    let mut random = Random::new(seed, 31);
    let mut stage = Stage::default();
    let orange = stage.material("sphere", 0xE29A5B);
    let mut sphere = MeshBuilder::new("sphere", orange);
    sphere.globe(GRID, |direction| direction);
    let sphere = stage.mesh(sphere.finish());
    for i in 0..COUNT {
        for j in 0..COUNT {
            let radius = random.range(0.5, 1.2);
            let free = PITCH / 2.0 - radius;
            let mut along =
                |k: u32| (f64::from(k) - f64::from(COUNT - 1) / 2.0) * PITCH + random.range(-free, free);
            let (x, z) = (along(i), along(j));
            let height = if (i + j) % 2 == 0 { 0.0 } else { random.range(0.5, 4.0) };
            let place = Placement::at([x, radius + height, z]).turned(random.angle()).scaled(radius);
            stage.place(sphere, format!("sphere {i} {j}"), place);
        }
    }
    stage.finish()
}
