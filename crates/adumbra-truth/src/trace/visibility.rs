//! Visibility of the sun and of the nearby sky from a point, by ray tracing. Convention: 1 = unoccluded.

use crate::trace::sampling::{around, cap, frame, points};
use crate::trace::{Ray, Tracer};
use adumbra::grid::vec3::normalize;

impl Tracer<'_> {
    /// Whether the ray from `point` along `towards`, the direction to the sun (any length), hits no caster.
    /// The point should be lifted off its surface. Cost: one ray.
    pub fn sun_visible(&self, point: [f64; 3], towards: [f64; 3]) -> bool {
        !self.occluded(&Ray { origin: point, direction: towards, t_min: 0.0, t_max: f64::INFINITY })
    }

    /// Fraction of the sun's disc that is visible from `point`: `samples` rays spread evenly over the cone
    /// with the full angle `angular_diameter_degrees` (clamped to 0 ..= 360) about `towards` (any length).
    /// The result is deterministic for a given `seed`. An angle of 0, or a single sample, is one ray to the
    /// centre. Cost: `samples` rays.
    pub fn sun_disc_visibility(
        &self,
        point: [f64; 3],
        towards: [f64; 3],
        angular_diameter_degrees: f64,
        samples: u32,
        seed: u64,
    ) -> f32 {
        let of_ray = |towards| f64::from(u8::from(self.sun_visible(point, towards)));
        mean_over_disc(towards, angular_diameter_degrees, samples, seed, of_ray)
    }

    /// Share of the light of the sun's disc that arrives at `point`: as
    /// [`sun_disc_visibility`](Self::sun_disc_visibility), but each ray brings what materials let through,
    /// see [`transmitted`](Self::transmitted). The two are equal if no material that casts a shadow does.
    pub fn sun_disc_light(
        &self,
        point: [f64; 3],
        towards: [f64; 3],
        angular_diameter_degrees: f64,
        samples: u32,
        seed: u64,
    ) -> f32 {
        let of_ray = |direction| {
            f64::from(self.transmitted(&Ray { origin: point, direction, t_min: 0.0, t_max: f64::INFINITY }))
        };
        mean_over_disc(towards, angular_diameter_degrees, samples, seed, of_ray)
    }

    /// Cosine-weighted fraction of the hemisphere about `normal` (any length) in which no caster is within
    /// `radius_world`, from `rays` rays; 1 if `rays` is 0. The result is deterministic for a given `seed`.
    /// The point should be lifted off its surface. Cost: `rays` rays.
    pub fn ambient_visibility(
        &self,
        point: [f64; 3],
        normal: [f64; 3],
        radius_world: f64,
        rays: u32,
        seed: u64,
    ) -> f32 {
        if rays == 0 {
            return 1.0;
        }
        let axis = normalize(normal);
        let sides = frame(axis);
        let open = points(rays, seed).filter(|&[u, v]| {
            let direction = around(axis, sides, u.sqrt(), (1.0 - u).max(0.0).sqrt(), v);
            !self.occluded(&Ray { origin: point, direction, t_min: 0.0, t_max: radius_world })
        });
        (open.count() as f64 / f64::from(rays)) as f32
    }
}

/// Mean of `of_ray` over directions spread evenly over a disc, as
/// [`sun_disc_visibility`](Tracer::sun_disc_visibility) describes it.
fn mean_over_disc(
    towards: [f64; 3],
    angular_diameter_degrees: f64,
    samples: u32,
    seed: u64,
    of_ray: impl Fn([f64; 3]) -> f64,
) -> f32 {
    let half = (0.5 * angular_diameter_degrees).clamp(0.0, 180.0).to_radians();
    if samples <= 1 || half == 0.0 || half.is_nan() {
        return of_ray(towards) as f32;
    }
    let axis = normalize(towards);
    let sides = frame(axis);
    let sum: f64 = points(samples, seed)
        .map(|[u, v]| {
            let (flat, height) = cap(u, half);
            of_ray(around(axis, sides, flat, height, v))
        })
        .sum();
    (sum / f64::from(samples)) as f32
}
