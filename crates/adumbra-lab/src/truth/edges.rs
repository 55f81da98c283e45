//! Whether a point lies clear of shadow edges.
//!
//! The notion is `adumbra::verify`'s *interior*: the point and its neighbours, moved in the light's plane and then along the light
//! onto the point's tangent plane, agree by rays. Here the neighbours stand on two rings of eight, at the whole radius and at half
//! of it, the inner one turned by a sixteenth of a circle, so that thin shadows do not slip between.

use adumbra::settings::MAX_SLOPE;
use rayon::prelude::*;

use super::{Surfaces, TruthTracer};
use crate::vector::{cross, dot, normalize};

/// Neighbours on a ring.
const RING: u32 = 8;

/// Asks rays about the neighbourhood of points.
#[derive(Debug)]
pub struct EdgeProbe<'a, 's> {
    truth: &'a TruthTracer<'s>,
    towards_sun: [f64; 3],
    /// Unit axes of the light's plane.
    sides: [[f64; 3]; 2],
}

impl<'a, 's> EdgeProbe<'a, 's> {
    /// A probe for a sun in the unit direction `towards_sun`.
    pub fn new(truth: &'a TruthTracer<'s>, towards_sun: [f64; 3]) -> Self {
        let other = if towards_sun[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
        let x = normalize(cross(other, towards_sun));
        Self { truth, towards_sun, sides: [x, cross(towards_sun, x)] }
    }

    /// Whether the point at `lifted_world`, just above a surface with the unit `normal`, is more than `radius_world`, in the light's plane, from
    /// an edge of the true hard shadow. A point turned away from the sun never is. Cost: up to 17 rays.
    pub fn is_clear(&self, lifted_world: [f64; 3], normal: [f64; 3], radius_world: f64) -> bool {
        let l = self.towards_sun;
        let n_dot_l = dot(normal, l);
        if n_dot_l <= 0.0 {
            return false;
        }
        let lit = |offset: [f64; 2]| {
            let [x, y] = self.sides;
            let aside: [f64; 3] = std::array::from_fn(|a| offset[0] * x[a] + offset[1] * y[a]);
            // Onto the tangent plane along the light, as steep as slopes count.
            let flat = (offset[0].powi(2) + offset[1].powi(2)).sqrt();
            let along = (-dot(normal, aside) / n_dot_l).clamp(-MAX_SLOPE * flat, MAX_SLOPE * flat);
            let origin = std::array::from_fn(|a| lifted_world[a] + aside[a] + along * l[a]);
            self.truth.tracer().sun_visible(origin, l)
        };
        let middle = lit([0.0; 2]);
        let ring = |radius: f64, turn: f64| {
            (0..RING).all(|i| {
                let (sin, cos) =
                    libm::sincos((f64::from(i) + turn) * std::f64::consts::TAU / f64::from(RING));
                lit([radius * cos, radius * sin]) == middle
            })
        };
        ring(radius_world, 0.0) && ring(0.5 * radius_world, 0.5)
    }

    /// [`EdgeProbe::is_clear`] of each pixel, with a radius in world units a pixel; false where there is no surface or the radius is not
    /// finite. Cost: up to 17 rays a pixel; rows on the current rayon pool.
    pub fn clear_pixels(&self, surfaces: &Surfaces, radius_world: impl Fn(usize) -> f64 + Sync) -> Vec<bool> {
        let width = (surfaces.width as usize).max(1);
        let mut clear = vec![false; surfaces.pixels()];
        clear.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, clear) in row.iter_mut().enumerate() {
                let i = y * width + x;
                let radius = radius_world(i);
                *clear = surfaces.is_valid(i)
                    && radius.is_finite()
                    && self.is_clear(surfaces.lifted(i), surfaces.normal[i].map(f64::from), radius);
            }
        });
        clear
    }
}
