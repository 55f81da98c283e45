//! Reports what a person would notice at a glance: how much of the ground, and of the places where people
//! stand, is in shadow, whether one part of the scene hides the sun from all others, and whether a stray
//! triangle makes the scene many times wider than its content.
//!
//! A file may agree with rays and still look wrong everywhere, because the scene is not what its owner
//! expects: it contains a sky dome, or a forgotten triangle 200 km away. This module therefore examines only
//! the scene. It casts a few thousand rays, and tests all of them in each pass over the triangles.

mod hider;
mod pencil;
mod spread;

use adumbra::Bounds;
use adumbra_scene::random::Random;
use adumbra_scene::{AlphaMode, Scene};

pub use hider::Hider;
use pencil::Pencil;
pub use spread::{Spread, Stray};

/// How high a person's eyes are above the ground, world units.
pub const EYE_HEIGHT_WORLD: f64 = 1.7;
/// Number of vertical lines along each horizontal side of the scene. A person may stand on each line.
const LINES: usize = 45;
const SEED: u64 = 2;
const UP: [f64; 3] = [0.0, 1.0, 0.0];
/// Distance by which a point is lifted off its surface, as a share of the scene's longest side.
const LIFT: f64 = 1e-6;

/// What a person would notice in a scene at a glance.
#[derive(Clone, Debug)]
pub struct Glance {
    /// Points on the lowest surfaces that face up, or at the scene's lowest height where there is no surface.
    pub ground: Vec<LitPoint>,
    /// Points at eye level above the ground points.
    pub standing: Vec<LitPoint>,
    /// The parts that hide the sun from nearly everything else, if there are any.
    pub hider: Option<Hider>,
    /// The extent of the scene, and strays outside it.
    pub spread: Spread,
}

/// A point, and whether rays from it reach the sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitPoint {
    /// The point.
    pub p_world: [f64; 3],
    /// Whether it sees the sun.
    pub is_lit: bool,
}

/// Returns the share of points in shadow, 0 to 1, or `None` if there are no points.
pub fn shadowed_share(points: &[LitPoint]) -> Option<f64> {
    let dark = points.iter().filter(|point| !point.is_lit).count();
    (!points.is_empty()).then(|| dark as f64 / points.len() as f64)
}

impl Glance {
    /// Examines a scene under a sun in the direction `towards_sun`, of length 1. Points inside solids are
    /// left out, because people do not stand in walls.
    ///
    /// Cost: seven passes over all triangles of all instances, on the current rayon pool; a few bytes per
    /// instance.
    pub fn of(scene: &Scene, towards_sun: [f64; 3], ignore_alpha: bool) -> Self {
        let spread = Spread::of(scene);
        let lift = LIFT * spread.side_world().max(f64::MIN_POSITIVE);
        let feet = feet(scene, &spread.around(&scene.bounds()), lift);
        let eyes: Vec<[f64; 3]> = feet.iter().map(|&[x, y, z]| [x, y + EYE_HEIGHT_WORLD, z]).collect();
        let outside = are_outside(scene, [&feet, &eyes]);
        let points: Vec<[f64; 3]> = feet.iter().chain(&eyes).copied().collect();
        let rays = Pencil::new(&points, towards_sun);
        let stopped = rays.fold(
            scene,
            || vec![false; points.len()],
            |stopped, crossing| {
                if crossing.distance > 0.0
                    && !stopped[crossing.point]
                    && crossing.casts(scene)
                    && crossing.is_opaque(scene, ignore_alpha)
                {
                    stopped[crossing.point] = true;
                }
            },
            either,
        );
        let hider = Hider::of(scene, towards_sun, ignore_alpha, lift);
        let seen = |first: usize, points: &[[f64; 3]]| {
            let all = points.iter().zip(&stopped[first..]).zip(&outside[first..]);
            let outside = all.filter(|(_, outside)| **outside);
            outside.map(|((&p_world, stopped), _)| LitPoint { p_world, is_lit: !stopped }).collect()
        };
        let (ground, standing) = (seen(0, &feet), seen(feet.len(), &eyes));
        Self { ground, standing, hider, spread }
    }
}

/// Returns where people stand: on each line the lowest surface, lifted. Prefers a surface that faces up and
/// casts, then one that faces up, then any surface, then the scene's lowest height.
fn feet(scene: &Scene, within: &Bounds, lift: f64) -> Vec<[f64; 3]> {
    // Each line has a random position in its cell, so that a regular town is not sampled at the same place of
    // each block.
    let mut random = Random::new(SEED, 0);
    let mut across = |axis: usize, i: usize| {
        let t = (i as f64 + random.unit()) / LINES as f64;
        within.min[axis] + t * (within.max[axis] - within.min[axis])
    };
    let lines: Vec<[f64; 3]> =
        (0..LINES * LINES).map(|i| [across(0, i % LINES), 0.0, across(2, i / LINES)]).collect();
    let lowest = Pencil::new(&lines, UP).fold(
        scene,
        || vec![[f64::INFINITY; 3]; lines.len()],
        |lowest, crossing| {
            let faces_up = crossing.is_from_behind;
            let kinds = [faces_up && crossing.casts(scene), faces_up, true];
            for (height, _) in lowest[crossing.point].iter_mut().zip(kinds).filter(|(_, is)| *is) {
                *height = height.min(crossing.distance);
            }
        },
        |mut one, other| {
            one.iter_mut().zip(other).for_each(|(a, b)| *a = [0, 1, 2].map(|i| a[i].min(b[i])));
            one
        },
    );
    let height =
        |lowest: [f64; 3]| lowest.into_iter().find(|height| height.is_finite()).unwrap_or(within.min[1]);
    lines.iter().zip(lowest).map(|(&[x, _, z], lowest)| [x, height(lowest) + lift, z]).collect()
}

/// Returns which points are not inside a solid. A ray from inside leaves more solids than it enters, however
/// they overlap: it crosses more back faces than front faces. A point counts as inside only if this holds for
/// three rays: upwards and to two sides. A decal, an awning or a bridge shows its back face only to the
/// upward ray. Masked surfaces do not bound solids.
fn are_outside(scene: &Scene, points: [&[[f64; 3]]; 2]) -> Vec<bool> {
    let points = points.concat();
    let is_free = |along: [f64; 3]| {
        let left = Pencil::new(&points, along).fold(
            scene,
            || vec![0_i32; points.len()],
            |left, crossing| {
                let is_opaque = scene.materials[crossing.material(scene) as usize].alpha == AlphaMode::Opaque;
                if crossing.distance > 0.0 && is_opaque && crossing.casts(scene) {
                    left[crossing.point] += if crossing.is_from_behind { 1 } else { -1 };
                }
            },
            |mut one, other| {
                one.iter_mut().zip(other).for_each(|(a, b)| *a += b);
                one
            },
        );
        left.into_iter().map(|left| left <= 0)
    };
    let [above, beside, before] = [UP, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]].map(is_free);
    above.zip(beside.zip(before)).map(|(above, (beside, before))| above || beside || before).collect()
}

fn either(mut one: Vec<bool>, other: Vec<bool>) -> Vec<bool> {
    one.iter_mut().zip(other).for_each(|(a, b)| *a |= b);
    one
}
