//! Test of whether a point is clear of shadow edges.
//!
//! The definition is that of *interior* in `adumbra_truth::verify`: rays give the same visibility of the sun
//! at the point and at its neighbours. The neighbours are offset in the light's plane and then projected
//! along the light onto the point's tangent plane. Here they form two rings of eight, at the full radius and
//! at half of it. The inner ring is rotated by a sixteenth of a circle, so that thin shadows do not fall
//! between the neighbours.

use adumbra::MAX_SLOPE;
use rayon::prelude::*;

use super::{Surfaces, TruthTracer};
use crate::vector::{cross, dot, normalize};

/// Number of neighbours on a ring.
const RING: u32 = 8;

/// Traces rays around points to find out whether they are near shadow edges.
#[derive(Debug)]
pub struct EdgeProbe<'a, 's> {
    truth: &'a TruthTracer<'s>,
    towards_sun: [f64; 3],
    /// Unit axes of the light's plane, which is perpendicular to the sun's direction.
    sides: [[f64; 3]; 2],
}

impl<'a, 's> EdgeProbe<'a, 's> {
    /// Creates a probe for a sun in the unit direction `towards_sun`.
    pub fn new(truth: &'a TruthTracer<'s>, towards_sun: [f64; 3]) -> Self {
        let other = if towards_sun[1].abs() < 0.9 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
        let x = normalize(cross(other, towards_sun));
        Self { truth, towards_sun, sides: [x, cross(towards_sun, x)] }
    }

    /// Whether a point is more than `radius_world` from an edge of the true hard shadow, measured in the
    /// light's plane.
    ///
    /// The point is at `lifted_world`, just above a surface with the unit `normal`. The result is false for
    /// points that face away from the sun.
    ///
    /// Cost: up to 17 rays.
    pub fn is_clear(&self, lifted_world: [f64; 3], normal: [f64; 3], radius_world: f64) -> bool {
        let l = self.towards_sun;
        let n_dot_l = dot(normal, l);
        if n_dot_l <= 0.0 {
            return false;
        }
        let lit = |offset: [f64; 2]| {
            let [x, y] = self.sides;
            let aside: [f64; 3] = std::array::from_fn(|a| offset[0] * x[a] + offset[1] * y[a]);
            // Projects along the light onto the tangent plane, with the slope limited to MAX_SLOPE.
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

    /// Returns [`EdgeProbe::is_clear`] for each pixel. `radius_world` gives the radius of a pixel in world
    /// units.
    ///
    /// The result is false at pixels without a surface or with a radius that is not finite.
    ///
    /// Cost: up to 17 rays per pixel. Rows run in parallel on the current rayon pool.
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
