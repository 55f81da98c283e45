//! Objects that move through a scene: `--move sphere`, a ball. It follows a path that the user gives, or one
//! that leads from sunlight into the shadow of something tall, as in Figure 5-3 of the voxel paper.

use std::str::FromStr;

use adumbra::Bounds;
use adumbra_scene::Scene;

use crate::trace::{Ray, Tracer};

/// Base colour of the ball, linear RGBA.
const BALL_COLOR: [f32; 4] = [0.80, 0.10, 0.06, 1.0];
/// Number of candidate positions tried along each horizontal side of the scene.
const COLUMNS: u32 = 128;
/// Length of a path in radii: minimum, ideal, maximum.
const LENGTHS: [f64; 3] = [8.0, 14.0, 24.0];
/// Casters nearer than this, in radii, are ignored in the search for a shadow to move into.
const NEAREST_CASTER: f64 = 3.0;
/// Minimum half width of a shadow to move into, in radii.
const WIDE: f64 = 4.0;
/// Azimuth of a camera relative to the sun, radians. From there, both the ball's lit side and its shadow are
/// visible.
const ASIDE: f64 = 1.1;
/// Number of keys of a path that the search finds, so that it follows the ground.
const KEYS: u32 = 9;

/// A mover as specified in text: `sphere[:radius=R][:from=X,Y,Z:to=X,Y,Z][:seconds=S]`.
#[derive(Clone, Debug, PartialEq)]
pub struct MoveSpec {
    /// Radius, world units. `None` picks one that suits the scene: 1, or less in a small scene.
    pub radius_world: Option<f64>,
    /// First and last world position of the ball's centre. `None` searches for a path.
    pub ends_world: Option<[[f64; 3]; 2]>,
    /// Duration, seconds.
    pub seconds: f64,
}

/// An invalid description of a mover, or a mover for which no path was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("mover {name:?}: {reason}")]
pub struct MoverError {
    /// The mover as it was given.
    pub name: String,
    /// What is wrong, and what would be accepted.
    pub reason: String,
}

/// The path of a ball.
#[derive(Clone, Debug, PartialEq)]
pub struct BallPath {
    /// Radius, world units.
    pub radius_world: f64,
    /// Times in seconds, ascending, each with the world position of the ball's centre. Interpolation is
    /// linear.
    pub keys: Vec<(f64, [f64; 3])>,
}

impl FromStr for MoveSpec {
    type Err = MoverError;

    fn from_str(text: &str) -> Result<Self, MoverError> {
        let wrong = |reason: String| MoverError { name: text.to_owned(), reason };
        let mut parts = text.split(':');
        if parts.next() != Some("sphere") {
            return Err(wrong("unknown mover; the only one is sphere".to_owned()));
        }
        let mut spec = Self { radius_world: None, ends_world: None, seconds: 4.0 };
        let (mut from, mut to) = (None, None);
        let mut seen = Vec::new();
        for part in parts {
            let (key, value) =
                part.split_once('=').ok_or_else(|| wrong(format!("{part:?} is not key=value")))?;
            if seen.contains(&key) {
                return Err(wrong(format!("{key:?} is given twice")));
            }
            seen.push(key);
            // A mover's track stores `f32`, so a number must be finite as `f32`.
            let number = |n: &str| n.trim().parse().ok().filter(|n: &f64| (*n as f32).is_finite());
            let numbers: Option<Vec<f64>> = value.split(',').map(number).collect();
            let numbers = numbers.unwrap_or_default();
            let above_0 = || match numbers[..] {
                [n] if n as f32 > 0.0 => Ok(n),
                _ => Err(wrong(format!("{key}={value}: give a number above 0"))),
            };
            let point = || match numbers[..] {
                [x, y, z] => Ok([x, y, z]),
                _ => Err(wrong(format!("{key}={value}: give three numbers separated by commas"))),
            };
            match key {
                "radius" => spec.radius_world = Some(above_0()?),
                "seconds" => spec.seconds = above_0()?,
                "from" => from = Some(point()?),
                "to" => to = Some(point()?),
                _ => {
                    return Err(wrong(format!(
                        "unknown parameter {key:?}; choose one of: radius, from, to, seconds"
                    )));
                }
            }
        }
        spec.ends_world = match (from, to) {
            (Some(from), Some(to)) => Some([from, to]),
            (None, None) => None,
            _ => return Err(wrong("give from and to, or neither".to_owned())),
        };
        Ok(spec)
    }
}

impl MoveSpec {
    /// Returns the path that was given, or else finds one in `still`, a tracer of the scene without movers.
    /// Cost of a search: about a hundred thousand rays.
    ///
    /// # Errors
    /// Returns [`MoverError`] if no sunlit position has a suitable shadow within reach, or if the path is
    /// invalid.
    pub fn path(&self, still: &Tracer<'_>, towards_sun: [f64; 3]) -> Result<BallPath, MoverError> {
        let bounds = still.scene().bounds();
        let radius_world =
            self.radius_world.unwrap_or_else(|| (still.scene().usual_diagonal() / 40.0).min(1.0));
        let seconds = |share: f64| share * self.seconds;
        if let Some([from, to]) = self.ends_world {
            return BallPath { radius_world, keys: vec![(0.0, from), (self.seconds, to)] }.checked();
        }
        let finder = Finder { still, bounds, towards_sun, radius: radius_world };
        let centers = finder.find().ok_or_else(|| MoverError {
            name: "sphere".to_owned(),
            reason: "found no free place in the sun with a shadow next to it; give from and to".to_owned(),
        })?;
        let last = f64::from(KEYS - 1);
        let keys = (0..).zip(centers).map(|(i, c)| (seconds(f64::from(i) / last), c)).collect();
        BallPath { radius_world, keys }.checked()
    }
}

impl BallPath {
    /// Returns this path if a ball can follow it.
    fn checked(self) -> Result<Self, MoverError> {
        let wrong = |reason: &str| MoverError { name: "sphere".to_owned(), reason: reason.to_owned() };
        if !(self.radius_world as f32 > 0.0 && (self.radius_world as f32).is_finite()) {
            return Err(wrong("its radius is not above 0 and finite; give radius"));
        }
        match Scene::default().add_ball(self.radius_world, BALL_COLOR, &self.keys) {
            Some(_) => Ok(self),
            None => Err(wrong("its path is empty, not finite, or goes back in time")),
        }
    }

    /// Adds the ball to a scene, as its last instance and as a mover. Does nothing for a path that
    /// [`MoveSpec::path`] would never return: one that is empty, not finite, or goes back in time.
    pub fn add_to(&self, scene: &mut Scene) {
        scene.add_ball(self.radius_world, BALL_COLOR, &self.keys);
    }

    /// Returns eye and target of a camera from which nothing in `still` hides the ball's centre at any key.
    /// It is the first such position of several rings around the path, lowest ring first and azimuths near
    /// `ASIDE` from the sun first, or the last position if none is free.
    pub fn viewpoint(&self, still: &Tracer<'_>, towards_sun: [f64; 3]) -> [[f64; 3]; 2] {
        let (first, last) = (self.keys[0].1, self.keys[self.keys.len() - 1].1);
        let target: [f64; 3] = std::array::from_fn(|a| 0.5 * (first[a] + last[a]));
        let length = (0..3).map(|a| (last[a] - first[a]).powi(2)).sum::<f64>().sqrt();
        let distance = 1.4 * length + 6.0 * self.radius_world;
        let sun_azimuth = towards_sun[2].atan2(towards_sun[0]);
        let eye = |turn: f64, rise: f64| -> [f64; 3] {
            let azimuth = sun_azimuth + turn;
            let level = distance * rise.cos();
            [
                target[0] + level * azimuth.cos(),
                target[1] + distance * rise.sin(),
                target[2] + level * azimuth.sin(),
            ]
        };
        let sees = |eye: [f64; 3]| {
            self.keys.iter().all(|(_, p)| {
                let direction = std::array::from_fn(|a| p[a] - eye[a]);
                !still.occluded(&Ray { origin: eye, direction, t_min: 0.0, t_max: 1.0 })
            })
        };
        // Ordered by elevation, from 25° up in steps of 14°, then by azimuth away from `ASIDE`.
        let places = (0..5).flat_map(|rise| (0..16).map(move |turn| (rise, turn)));
        let places = places.map(|(rise, turn)| {
            let side = if turn % 2 == 0 { 1.0 } else { -1.0 };
            let turn = side * f64::from((turn + 1) / 2) * std::f64::consts::PI / 8.0;
            eye(turn + ASIDE, (25.0 + 14.0 * f64::from(rise)).to_radians())
        });
        let places: Vec<[f64; 3]> = places.collect();
        let free = places.iter().position(|&e| sees(e)).unwrap_or(places.len() - 1);
        [places[free], target]
    }
}

/// Finds a path from sunlight into shadow.
struct Finder<'a> {
    still: &'a Tracer<'a>,
    bounds: Bounds,
    towards_sun: [f64; 3],
    radius: f64,
}

/// A position of the ball resting on the ground.
#[derive(Clone, Copy)]
struct BallPosition {
    center: [f64; 3],
    lit: bool,
    /// Whether the ball is fully in the wide shadow of casters at least [`NEAREST_CASTER`] radii away.
    shadowed: bool,
}

impl Finder<'_> {
    /// Returns the ball's centre at each key of the path closest to the ideal length and to the lowest
    /// ground. Up to rounding, the result is the same on every machine.
    fn find(&self) -> Option<Vec<[f64; 3]>> {
        let b = &self.bounds;
        let step = [0, 2].map(|a| (b.max[a] - b.min[a]) / f64::from(COLUMNS));
        let at = |i: u32, j: u32| {
            let x = b.min[0] + (f64::from(i) + 0.5) * step[0];
            let z = b.min[2] + (f64::from(j) + 0.5) * step[1];
            self.place(x, z)
        };
        let places: Vec<Option<BallPosition>> =
            (0..COLUMNS).flat_map(|j| (0..COLUMNS).map(move |i| (i, j))).map(|(i, j)| at(i, j)).collect();
        let reach = step.map(|s| (LENGTHS[2] * self.radius / s.max(1e-9)).min(f64::from(COLUMNS)) as i64);
        let height = (b.max[1] - b.min[1]).max(1e-9);
        let mut ways: Vec<(f64, [u32; 2])> = Vec::new();
        for (from, start) in (0_u32..).zip(&places) {
            let Some(start) = start.filter(|p| p.lit) else { continue };
            let (i, j) = (i64::from(from % COLUMNS), i64::from(from / COLUMNS));
            let near =
                (-reach[1]..=reach[1]).flat_map(|dj| (-reach[0]..=reach[0]).map(move |di| (i + di, j + dj)));
            for (i, j) in near.filter(|(i, j)| [i, j].iter().all(|v| (0..i64::from(COLUMNS)).contains(*v))) {
                let to = (j * i64::from(COLUMNS) + i) as u32;
                let Some(end) = places[to as usize].filter(|p| p.shadowed) else { continue };
                let length = distance(start.center, end.center) / self.radius;
                let level = (start.center[1] - end.center[1]).abs() < self.radius;
                if level && (LENGTHS[0]..=LENGTHS[2]).contains(&length) {
                    // Prefer the street to the roofs.
                    let high = 10.0 * (start.center[1] - b.min[1]) / height;
                    ways.push(((length - LENGTHS[1]).abs() + high, [from, to]));
                }
            }
        }
        ways.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let center = |at: u32| places[at as usize].map(|p| p.center);
        ways.iter().find_map(|&(_, [from, to])| self.way(center(from)?, center(to)?))
    }

    /// Places the ball on the highest surface at (x, z), if there is one, it is nearly level and the ball has
    /// room there.
    fn place(&self, x: f64, z: f64) -> Option<BallPosition> {
        let ground = self.ground(x, z)?;
        let center = [x, ground + self.radius, z];
        let r = 0.95 * self.radius;
        let around = [[0.0; 3], [r, 0.0, 0.0], [-r, 0.0, 0.0], [0.0, r, 0.0], [0.0, 0.0, r], [0.0, 0.0, -r]];
        let points = around.map(|d| std::array::from_fn(|a| center[a] + d[a]));
        let to_sun = |origin: [f64; 3], t_min: f64| Ray {
            origin,
            direction: self.towards_sun,
            t_min,
            t_max: f64::INFINITY,
        };
        let lit = points.iter().all(|&p| !self.still.occluded(&to_sun(p, 0.0)));
        let away = NEAREST_CASTER * self.radius;
        // The shadow must be wide, such as a building's: it covers the whole ball and its surroundings.
        let wide =
            around.map(|d| std::array::from_fn(|a| center[a] + if a == 1 { 0.0 } else { WIDE * d[a] }));
        let shadowed = !lit && points.iter().chain(&wide).all(|&p| self.still.occluded(&to_sun(p, away)));
        // Nothing may be within reach of the ball.
        let free = around[1..].iter().all(|&d| {
            let direction = d.map(|c| 1.5 * c);
            d[1] != 0.0 || !self.still.occluded(&Ray { origin: center, direction, t_min: 0.0, t_max: 1.0 })
        });
        free.then_some(BallPosition { center, lit, shadowed })
    }

    /// Returns the height of the highest surface at (x, z), if it is nearly level.
    fn ground(&self, x: f64, z: f64) -> Option<f64> {
        let top = self.bounds.max[1] + 1.0;
        let down = Ray { origin: [x, top, z], direction: [0.0, -1.0, 0.0], t_min: 0.0, t_max: f64::INFINITY };
        let hit = self.still.nearest_surface(&down)?;
        (hit.normal[1].abs() > 0.95).then_some(top - hit.t)
    }

    /// Returns the keys of a straight path between two positions, if the ground is even and nothing is in the
    /// way.
    fn way(&self, from: [f64; 3], to: [f64; 3]) -> Option<Vec<[f64; 3]>> {
        let aside = [-(to[2] - from[2]), 0.0, to[0] - from[0]];
        let flat = aside[0].hypot(aside[2]).max(1e-9);
        for side in [-1.0, 0.0, 1.0] {
            let origin = std::array::from_fn(|a| from[a] + side * self.radius * aside[a] / flat);
            let direction = std::array::from_fn(|a| to[a] - from[a]);
            if self.still.occluded(&Ray { origin, direction, t_min: 0.0, t_max: 1.0 }) {
                return None;
            }
        }
        let steps = (distance(from, to) / (0.5 * self.radius)).ceil().max(2.0) as u32;
        let mut before = from[1];
        for i in 1..=steps {
            let t = f64::from(i) / f64::from(steps);
            let [x, z] = [0, 2].map(|a| from[a] + t * (to[a] - from[a]));
            let height = self.ground(x, z)? + self.radius;
            if (height - before).abs() > 0.2 * self.radius {
                return None;
            }
            before = height;
        }
        let key = |i: u32| {
            let t = f64::from(i) / f64::from(KEYS - 1);
            let [x, z] = [0, 2].map(|a| from[a] + t * (to[a] - from[a]));
            Some([x, self.ground(x, z)? + self.radius, z])
        };
        (0..KEYS).map(key).collect()
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
