//! Selection of a street-level camera for any scene, by ray tracing. The result is deterministic.
//!
//! Candidate places are the ground points below a grid of rays from the sky. Places above their surroundings
//! (roofs) and in nearly closed yards are rejected. The others are ranked by the share of their surroundings
//! that is higher, minus twice the share that is lower. From the best places, small pictures are traced in
//! eight directions. The winner shows walls, ground, a long view ahead, and both light and shadow with many
//! edges. Lengths scale with the eye height.

use adumbra_scene::{Camera, Projection, View};
use adumbra_truth::trace::{Hit, Ray, Tracer};
use rayon::prelude::*;

use super::TruthTracer;
use crate::error::{Error, Result};
use crate::vector::dot;

/// Requirements on the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreetOptions {
    /// Height of the eye above the ground in world units; 1.7 if these are metres.
    pub eye_height_world: f64,
    /// Vertical field of view in degrees.
    pub fov_degrees: f64,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

impl Default for StreetOptions {
    fn default() -> Self {
        Self { eye_height_world: 1.7, fov_degrees: 60.0, width: 1280, height: 720 }
    }
}

/// Number of candidate places along x and along z.
const GRID: u32 = 32;
/// Number of places from which pictures are traced.
const FINALISTS: usize = 64;
/// Number of viewing directions per place.
const DIRECTIONS: u32 = 8;
/// Number of directions around a place in which heights are sampled.
const AROUND: u32 = 12;
/// Distances from a place at which heights are sampled, in eye heights.
const RINGS: [f64; 3] = [5.0, 12.0, 25.0];
/// Width and height of the small pictures in pixels.
const SMALL: [u32; 2] = [32, 18];
/// Smallest free distance ahead, in eye heights, of a view along a street.
const LONG: f64 = 40.0;
/// Smallest cosine between the normal of a ground surface and straight up.
const LEVEL: f64 = 0.85;

/// Returns a street-level camera for a scene under a sun in the unit direction `towards_sun`.
///
/// Cost: about half a million rays, on the current rayon pool.
///
/// # Errors
/// Returns [`Error::NoStreet`] if no place is suitable.
pub fn street_camera(
    truth: &TruthTracer<'_>,
    towards_sun: [f64; 3],
    options: &StreetOptions,
) -> Result<Camera> {
    let scout = Scout { truth, tracer: truth.tracer(), towards_sun, options: *options };
    let mut places: Vec<Viewpoint> =
        (0..GRID * GRID).into_par_iter().filter_map(|i| scout.place(i)).collect();
    places.sort_by(|a, b| b.rank.total_cmp(&a.rank));
    places.truncate(FINALISTS);
    let views: Vec<(f64, Camera)> = places
        .par_iter()
        .flat_map_iter(|place| (0..DIRECTIONS).map(|d| scout.camera(place.eye, d)))
        .filter_map(|camera| scout.score(&camera).map(|score| (score, camera)))
        .collect();
    // Takes the first of equal scores, so that the result does not depend on the threads.
    let best = views.iter().reduce(|best, view| if view.0 > best.0 { view } else { best });
    best.map(|(_, camera)| *camera).ok_or(Error::NoStreet)
}

struct Scout<'a, 's> {
    truth: &'a TruthTracer<'s>,
    tracer: &'a Tracer<'s>,
    towards_sun: [f64; 3],
    options: StreetOptions,
}

struct Viewpoint {
    eye: [f64; 3],
    rank: f64,
}

impl Scout<'_, '_> {
    fn unit(&self) -> f64 {
        self.options.eye_height_world
    }

    fn first(&self, origin: [f64; 3], direction: [f64; 3]) -> Option<Hit> {
        self.tracer.nearest_surface(&Ray { origin, direction, t_min: 0.0, t_max: f64::INFINITY })
    }

    /// Returns the height of the topmost surface at x, z, and the cosine of its slope.
    fn top(&self, x: f64, z: f64) -> Option<(f64, f64)> {
        let above = self.truth.bounds().max[1] + self.unit();
        let hit = self.first([x, above, z], [0.0, -1.0, 0.0])?;
        Some((above - hit.t, hit.normal[1].abs()))
    }

    /// Returns the `number`th place if it is on the ground and outdoors.
    fn place(&self, number: u32) -> Option<Viewpoint> {
        let bounds = self.truth.bounds();
        let along = |a: usize, i: u32| {
            // The grid covers the middle nine tenths of the bounds.
            let share = 0.05 + 0.9 * (f64::from(i) + 0.5) / f64::from(GRID);
            bounds.min[a] + share * (bounds.max[a] - bounds.min[a])
        };
        let (x, z) = (along(0, number % GRID), along(2, number / GRID));
        let (ground, cosine) = self.top(x, z)?;
        if cosine < LEVEL {
            return None;
        }
        let (mut higher, mut lower, mut seen) = (0.0, 0.0, 0.0);
        for (i, radius) in (0..AROUND).flat_map(|i| RINGS.map(|r| (i, r * self.unit()))) {
            let (sin, cos) = turn(i, AROUND);
            let Some((top, _)) = self.top(x + radius * cos, z + radius * sin) else { continue };
            seen += 1.0;
            // Smaller height differences are terrain, not roofs or walls.
            let allowed = 1.2 * self.unit() + 0.25 * radius;
            higher += f64::from(u8::from(top > ground + allowed));
            lower += f64::from(u8::from(top < ground - allowed));
        }
        let whole: f64 = f64::from(AROUND) * RINGS.len() as f64;
        if seen < 0.5 * whole || lower > 0.1 * seen || higher > 0.8 * seen {
            return None;
        }
        let eye = [x, ground + self.unit(), z];
        let open = (0..AROUND).filter(|&i| {
            let (sin, cos) = turn(i, AROUND);
            self.first(eye, [cos, 1.5, sin]).is_none()
        });
        (3 * open.count() >= AROUND as usize)
            .then(|| Viewpoint { eye, rank: higher / seen - 2.0 * lower / seen })
    }

    fn camera(&self, eye: [f64; 3], direction: u32) -> Camera {
        let (sin, cos) = turn(direction, DIRECTIONS);
        let target = [eye[0] + 10.0 * self.unit() * cos, eye[1], eye[2] + 10.0 * self.unit() * sin];
        let StreetOptions { fov_degrees, width, height, .. } = self.options;
        Camera { eye, target, projection: Projection::Perspective { fov_degrees }, width, height }
    }

    /// Returns the score of a view, or `None` if it is blocked nearby, shows too little ground, or lacks
    /// light or shadow.
    fn score(&self, camera: &Camera) -> Option<f64> {
        let [width, height] = SMALL;
        let view = Camera { width, height, ..*camera }.view();
        let all = f64::from(width * height);
        let (mut ground, mut walls, mut near, mut far, mut edges) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let (mut lit, mut shadowed) = (0.0, 0.0);
        // Whether the previous pixel was lit, if it faced the sun.
        let mut before: Option<bool> = None;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let last = before.take().filter(|_| x > 0);
            let Some((hit, p, normal)) = self.seen(&view, x, y) else { continue };
            if normal[1] > LEVEL && p[1] < camera.eye[1] {
                ground += 1.0;
            } else {
                walls += 1.0;
                near += f64::from(u8::from(hit.t < 3.0 * self.unit()));
            }
            far += f64::from(u8::from(hit.t > 10.0 * self.unit()));
            if dot(normal, self.towards_sun) > 0.1 {
                let lift = self.tracer.lift_world(&hit, p);
                let origin = std::array::from_fn(|a| p[a] + lift * normal[a]);
                let sees_sun = self.tracer.sun_visible(origin, self.towards_sun);
                if sees_sun {
                    lit += 1.0;
                } else {
                    shadowed += 1.0;
                }
                edges += f64::from(u8::from(last.is_some_and(|l| l != sees_sun)));
                before = Some(sees_sun);
            }
        }
        if near > 0.1 * all || ground < 0.1 * all || lit + shadowed == 0.0 {
            return None;
        }
        let share: f64 = shadowed / (lit + shadowed);
        let mixed = 4.0 * share * (1.0 - share);
        let capped = |count: f64, most: f64| (count / all).min(most) / most;
        // Favours views along a street over views at its side.
        let ahead = self.first(camera.eye, view.forward).map_or(f64::INFINITY, |hit| hit.t);
        let along = (ahead / (LONG * self.unit())).min(1.0);
        // Each term saturates, and most are at least 0.1, so that no single one decides.
        let edges = 0.1 + capped(edges, 0.1);
        (mixed > 0.0)
            .then(|| mixed * edges * (0.1 + along) * (0.1 + capped(walls, 0.45)) * (0.1 + capped(far, 0.35)))
    }

    fn seen(&self, view: &View, x: u32, y: u32) -> Option<(Hit, [f64; 3], [f64; 3])> {
        let (origin, direction) = view.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let hit = self.first(origin, direction)?;
        let side = if dot(hit.normal, direction) > 0.0 { -1.0 } else { 1.0 };
        let p = std::array::from_fn(|a| origin[a] + hit.t * direction[a]);
        Some((hit, p, hit.normal.map(|c| c * side)))
    }
}

/// Returns sine and cosine of the `i`th of `of` equal steps of a full turn. The angles are slightly off the
/// axes: streets run along the axes, and the places of the grid are rarely in the middle of a street.
fn turn(i: u32, of: u32) -> (f64, f64) {
    libm::sincos((f64::from(i) + 0.15) * std::f64::consts::TAU / f64::from(of))
}
