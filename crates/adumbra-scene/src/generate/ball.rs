//! A dimpled ball resting on the origin. Its triangle count matches the ball model of Li, Yang, Zhao and
//! Chen, *Hybrid-resolution shadow map*, 2016, whose shape the paper does not specify.

use std::f64::consts::PI;

use crate::generate::shapes::MeshBuilder;
use crate::generate::{Scene, Stage};
use crate::random::Random;
use adumbra::grid::vec3::dot;

/// Segments around and rings from pole to pole: 2 · 400 · (337 - 1) = 268,800 triangles.
const GRID: [u32; 2] = [400, 337];
/// Number of dimple positions. Dimples that would reach a pole are omitted, so that the ball is exactly 2
/// high.
const DIMPLES: u32 = 360;

/// A dimple, circular as seen from the ball's centre.
struct Dimple {
    direction: [f64; 3],
    /// Distance from its centre on the unit ball to its rim.
    radius: f64,
    depth: f64,
}

pub(super) fn generate(seed: u64) -> Scene {
    let mut stage = Stage::default();
    let white = stage.material("ball", 0xE8E4DA);
    let dimples = dimples(seed);
    let mut ball = MeshBuilder::new("ball", white);
    ball.globe(GRID, |direction| {
        let radius =
            dimples.iter().fold(1.0, |radius: f64, dimple| radius.min(dimple.ball_radius(direction)));
        let [x, y, z] = direction.map(|c| c * radius);
        [x, y + 1.0, z]
    });
    stage.mesh_in_place(ball.finish());
    stage.finish()
}

/// Dimples along an equal-area spiral, each a golden angle after the previous one.
fn dimples(seed: u64) -> Vec<Dimple> {
    let mut random = Random::new(seed, 30);
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let start = random.angle();
    (0..DIMPLES)
        .map(|k| {
            let y = 1.0 - f64::from(2 * k + 1) / f64::from(DIMPLES);
            let (across, angle) = ((1.0 - y * y).sqrt(), start + golden_angle * f64::from(k));
            Dimple {
                direction: [across * libm::cos(angle), y, across * libm::sin(angle)],
                radius: random.range(0.07, 0.095),
                depth: random.range(0.015, 0.03),
            }
        })
        .filter(|dimple| [1.0, -1.0].iter().all(|&pole| dimple.ball_radius([0.0, pole, 0.0]) >= 1.0))
        .collect()
}

impl Dimple {
    /// The ball's radius in this unit direction, considering only this dimple.
    fn ball_radius(&self, direction: [f64; 3]) -> f64 {
        let away = [0, 1, 2].map(|a| (self.direction[a] - direction[a]) / self.radius);
        1.0 - self.depth * (1.0 - dot(away, away)).max(0.0)
    }
}
