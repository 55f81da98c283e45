//! Visible points, with the results of rays from them.

use std::f64::consts::{PI, TAU};

use adumbra::grid::vec3::dot;
use adumbra_scene::random::Random;
use adumbra_truth::trace::{Ray, Tracer};
use rayon::prelude::*;

/// Surfaces whose cosine to the sun is below this are shaded by themselves, with or without shadows.
pub const LEAST_N_DOT_L: f64 = 0.05;
/// Number of tries for a point before it is skipped.
const TRIES: u32 = 256;

/// A visible point on a surface.
#[derive(Clone, Copy, Debug)]
pub struct VisiblePoint {
    /// World position.
    pub p_world: [f64; 3],
    /// Unit normal on the visible side.
    pub normal: [f64; 3],
    /// Where rays begin, just above the surface.
    pub lifted_world: [f64; 3],
}

/// Returns visible points: every other one seen from above at a slant, the others from standing places in the
/// scene. Returns fewer points than requested if most of the scene's space is empty. The points depend only
/// on the seed.
pub fn visible_points(tracer: &Tracer<'_>, count: usize, seed: u64) -> Vec<VisiblePoint> {
    let bounds = tracer.scene().bounds();
    let diagonal = bounds.diagonal();
    if !(diagonal > 0.0 && diagonal.is_finite()) {
        return Vec::new();
    }
    let eye_height = 0.01 * (bounds.max[1] - bounds.min[1]).min(170.0);
    let point = |index: usize| {
        let mut random = Random::new(seed, index as u64);
        (0..TRIES).find_map(|_| {
            let mut within =
                |axis: usize| bounds.min[axis] + random.unit() * (bounds.max[axis] - bounds.min[axis]);
            let [x, y, z] = [within(0), within(1), within(2)];
            let turn = TAU * random.unit();
            let (origin, direction) = if index.is_multiple_of(2) {
                let elevation = PI * (0.11 + 0.29 * random.unit());
                let (sin, cos) = elevation.sin_cos();
                let d = [-cos * turn.cos(), -sin, -cos * turn.sin()];
                ([x - d[0] * diagonal, y - d[1] * diagonal, z - d[2] * diagonal], d)
            } else {
                let top = bounds.max[1] + eye_height;
                let down = Ray {
                    origin: [x, top, z],
                    direction: [0.0, -1.0, 0.0],
                    t_min: 0.0,
                    t_max: f64::INFINITY,
                };
                let ground = tracer.nearest_surface(&down)?;
                let (sin, cos) = (random.unit() - 0.5).sin_cos();
                ([x, top - ground.t + eye_height, z], [cos * turn.cos(), sin, cos * turn.sin()])
            };
            let hit =
                tracer.nearest_surface(&Ray { origin, direction, t_min: 1e-6, t_max: f64::INFINITY })?;
            let p_world = std::array::from_fn(|a| origin[a] + hit.t * direction[a]);
            let normal = if hit.front { hit.normal } else { hit.normal.map(|c| -c) };
            let lift = tracer.lift_world(&hit, p_world);
            let lifted_world = std::array::from_fn(|a| p_world[a] + lift * normal[a]);
            Some(VisiblePoint { p_world, normal, lifted_world })
        })
    };
    (0..count).into_par_iter().filter_map(point).collect()
}

impl VisiblePoint {
    /// Whether the surface faces a sun, a unit vector.
    pub fn faces(&self, towards_sun: [f64; 3]) -> bool {
        dot(self.normal, towards_sun) > LEAST_N_DOT_L
    }
}

/// Returns the points that face a sun, a unit vector, each with whether rays find it lit.
pub(crate) fn seen(
    tracer: &Tracer<'_>,
    points: &[VisiblePoint],
    towards_sun: [f64; 3],
) -> Vec<(VisiblePoint, bool)> {
    let facing = points.par_iter().filter(|point| point.faces(towards_sun));
    facing.map(|point| (*point, tracer.sun_visible(point.lifted_world, towards_sun))).collect()
}
