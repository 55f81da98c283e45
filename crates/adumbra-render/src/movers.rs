//! Things that move through a scene: `--move sphere`, a ball on a path that the user gives, or on one that leads from the sun into the
//! shade of something tall, as the ball of the voxel paper's Figure 5-3.

use std::str::FromStr;

use adumbra::scene::{Bounds, Scene};
use adumbra::trace::{Ray, Tracer};

use crate::error::{RenderError, Result};

/// Linear.
const BALL_COLOR: [f32; 4] = [0.80, 0.10, 0.06, 1.0];
/// Columns tried along each side of the scene.
const COLUMNS: u32 = 128;
/// Lengths of a path in radii: at least, at best, at most.
const LENGTHS: [f64; 3] = [8.0, 14.0, 24.0];
/// A caster nearer than this, in radii, is not what casts a shade to walk into.
const NEAREST_CASTER: f64 = 3.0;
/// Half width of a shade to walk into, in radii.
const WIDE: f64 = 4.0;
/// A camera stands so many radians aside of the sun: the ball's lit side and its shadow are both seen.
const ASIDE: f64 = 1.1;
/// Keys of a path, so that it follows the ground.
const KEYS: u32 = 9;

/// A mover as it is asked for: `sphere[:radius=R][:from=X,Y,Z:to=X,Y,Z][:seconds=S]`.
#[derive(Clone, Debug, PartialEq)]
pub struct MoveSpec {
    /// World units; none suits the scene: 1, or less in a small one.
    pub radius_world: Option<f64>,
    /// Where the ball's centre goes, first and last; none finds a path.
    pub ends_world: Option<[[f64; 3]; 2]>,
    /// How long it takes.
    pub seconds: f64,
}

/// Where a ball goes.
#[derive(Clone, Debug, PartialEq)]
pub struct BallPath {
    /// World units.
    pub radius_world: f64,
    /// Seconds, rising, and the ball's centre then; straight between them.
    pub keys: Vec<(f64, [f64; 3])>,
}

impl FromStr for MoveSpec {
    type Err = RenderError;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = |reason: String| RenderError::Mover { name: text.to_owned(), reason };
        let mut parts = text.split(':');
        if parts.next() != Some("sphere") {
            return Err(wrong("there is: sphere".to_owned()));
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
            // As a mover's track holds them.
            let number = |n: &str| n.trim().parse().ok().filter(|n: &f64| (*n as f32).is_finite());
            let numbers: Option<Vec<f64>> = value.split(',').map(number).collect();
            let numbers = numbers.unwrap_or_default();
            let above_0 = || match numbers[..] {
                [n] if n as f32 > 0.0 => Ok(n),
                _ => Err(wrong(format!("{key}={value}: give a number above 0"))),
            };
            let point = || match numbers[..] {
                [x, y, z] => Ok([x, y, z]),
                _ => Err(wrong(format!("{key}={value}: give three numbers with commas between"))),
            };
            match key {
                "radius" => spec.radius_world = Some(above_0()?),
                "seconds" => spec.seconds = above_0()?,
                "from" => from = Some(point()?),
                "to" => to = Some(point()?),
                _ => return Err(wrong(format!("{key:?}: there are radius, from, to and seconds"))),
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
    /// The path, found in `still` if none is given: a scene without movers, ready for rays. Cost: about a hundred thousand rays where
    /// it is to be found.
    ///
    /// # Errors
    /// [`RenderError::Mover`] where no place in the sun has a shade to go to, or the path is one that no mover can take.
    pub fn path(&self, still: &Tracer<'_>, towards_sun: [f64; 3]) -> Result<BallPath> {
        let bounds = still.scene().bounds();
        let radius_world =
            self.radius_world.unwrap_or_else(|| (still.scene().usual_diagonal() / 40.0).min(1.0));
        let seconds = |share: f64| share * self.seconds;
        if let Some([from, to]) = self.ends_world {
            return BallPath { radius_world, keys: vec![(0.0, from), (self.seconds, to)] }.checked();
        }
        let finder = Finder { still, bounds, towards_sun, radius: radius_world };
        let centers = finder.find().ok_or_else(|| RenderError::Mover {
            name: "sphere".to_owned(),
            reason: "no free place in the sun with a shade beside it was found; give from and to".to_owned(),
        })?;
        let last = f64::from(KEYS - 1);
        let keys = (0..).zip(centers).map(|(i, c)| (seconds(f64::from(i) / last), c)).collect();
        BallPath { radius_world, keys }.checked()
    }
}

impl BallPath {
    /// This path, if a ball can go along it.
    fn checked(self) -> Result<Self> {
        let wrong =
            |reason: &str| RenderError::Mover { name: "sphere".to_owned(), reason: reason.to_owned() };
        if !(self.radius_world as f32 > 0.0 && (self.radius_world as f32).is_finite()) {
            return Err(wrong("its radius is not above 0 and finite; give radius"));
        }
        match Scene::default().add_ball(self.radius_world, BALL_COLOR, &self.keys) {
            Some(_) => Ok(self),
            None => Err(wrong("its way is empty, not finite, or goes back in time")),
        }
    }

    /// Adds the ball to a scene, as its last instance and a mover. Nothing is added of a way that [`MoveSpec::path`] would not give:
    /// empty, not finite, or back in time.
    pub fn add_to(&self, scene: &mut Scene) {
        scene.add_ball(self.radius_world, BALL_COLOR, &self.keys);
    }

    /// Eye and target of a camera from which nothing of `still` hides the ball on its way: the first of a ring of places about the
    /// path, those near `ASIDE` of the sun before others.
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
        // By height: from 25° up; then by how far it is turned from the sun.
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

/// Looks for a path from sun into shade.
struct Finder<'a> {
    still: &'a Tracer<'a>,
    bounds: Bounds,
    towards_sun: [f64; 3],
    radius: f64,
}

/// A place on the ground where the ball may stand.
#[derive(Clone, Copy)]
struct Place {
    center: [f64; 3],
    lit: bool,
    /// Fully, by casters that stand away.
    shadowed: bool,
}

impl Finder<'_> {
    /// Centres of the keys of the path whose length suits best; the same on every machine up to rounding.
    fn find(&self) -> Option<Vec<[f64; 3]>> {
        let b = &self.bounds;
        let step = [0, 2].map(|a| (b.max[a] - b.min[a]) / f64::from(COLUMNS));
        let at = |i: u32, j: u32| {
            let x = b.min[0] + (f64::from(i) + 0.5) * step[0];
            let z = b.min[2] + (f64::from(j) + 0.5) * step[1];
            self.place(x, z)
        };
        let places: Vec<Option<Place>> =
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
                    // The street before the roofs.
                    let high = 10.0 * (start.center[1] - b.min[1]) / height;
                    ways.push(((length - LENGTHS[1]).abs() + high, [from, to]));
                }
            }
        }
        ways.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let center = |at: u32| places[at as usize].map(|p| p.center);
        ways.iter().find_map(|&(_, [from, to])| self.way(center(from)?, center(to)?))
    }

    /// The ball on the ground below the sky at (x, z), if there is ground and it is nearly level.
    fn place(&self, x: f64, z: f64) -> Option<Place> {
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
        // A wide shade, such as a building's: the ball is in it as a whole, and so is its surrounding.
        let wide =
            around.map(|d| std::array::from_fn(|a| center[a] + if a == 1 { 0.0 } else { WIDE * d[a] }));
        let shadowed = !lit && points.iter().chain(&wide).all(|&p| self.still.occluded(&to_sun(p, away)));
        // Nothing may stand within the ball's reach.
        let free = around[1..].iter().all(|&d| {
            let direction = d.map(|c| 1.5 * c);
            d[1] != 0.0 || !self.still.occluded(&Ray { origin: center, direction, t_min: 0.0, t_max: 1.0 })
        });
        free.then_some(Place { center, lit, shadowed })
    }

    /// Height of the highest surface at (x, z), if it is nearly level.
    fn ground(&self, x: f64, z: f64) -> Option<f64> {
        let top = self.bounds.max[1] + 1.0;
        let down = Ray { origin: [x, top, z], direction: [0.0, -1.0, 0.0], t_min: 0.0, t_max: f64::INFINITY };
        let hit = self.still.nearest_surface(&down)?;
        (hit.normal[1].abs() > 0.95).then_some(top - hit.t)
    }

    /// Keys from one place to another over even ground with nothing in the way.
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
