//! Points at which light is measured.

mod csv;
mod grid;
mod surfaces;

use adumbra::grid::vec3::dot;

pub use csv::read_csv;
pub use grid::{Grid, GridPoints};
pub use surfaces::surface_points;

use crate::error::{Error, Result};

/// Largest number of points.
pub const MAX_POINTS: u64 = 200_000_000;

/// How a point faces the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facing {
    /// A point in space, lit from anywhere.
    Space,
    /// On a surface with this unit normal, dark from behind.
    Front([f64; 3]),
    /// On a sheet with this unit normal, lit from either side.
    Both([f64; 3]),
}

/// A point at which light is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// World position.
    pub p_world: [f64; 3],
    /// How it faces the light.
    pub facing: Facing,
    /// Distance above the surface at which rays start, world units.
    pub lift_world: f64,
}

impl Receiver {
    /// The unit normal; `None` for a point in space.
    pub fn normal(&self) -> Option<[f64; 3]> {
        match self.facing {
            Facing::Space => None,
            Facing::Front(normal) | Facing::Both(normal) => Some(normal),
        }
    }

    /// Whether light from `towards` arrives at the front, or at a point in space.
    pub(crate) fn faces(&self, towards: [f64; 3]) -> bool {
        self.normal().is_none_or(|normal| dot(normal, towards) > 0.0)
    }

    /// Where rays start: in front of the surface (side 1), or behind it (side -1).
    pub(crate) fn origin(&self, side: f64) -> [f64; 3] {
        let lift = self.lift_world * side;
        let normal = self.normal().unwrap_or_default();
        std::array::from_fn(|a| self.p_world[a] + lift * normal[a])
    }
}

/// Checks a spacing between points, and that it gives no more than [`MAX_POINTS`] of them.
fn check_spacing(spacing_world: f64, points: impl FnOnce(f64) -> f64) -> Result<()> {
    if !(spacing_world > 0.0 && spacing_world.is_finite()) {
        let expected = "a length above 0 in the scene's unit";
        return Err(Error::Range { field: "spacing", value: spacing_world, expected });
    }
    let points = points(spacing_world).ceil();
    if points <= MAX_POINTS as f64 {
        return Ok(());
    }
    Err(Error::TooManyPoints { spacing_world, points, most: MAX_POINTS })
}

/// Refuses an empty list of points.
fn some(points: Vec<Receiver>, place: &'static str, advice: &'static str) -> Result<Vec<Receiver>> {
    if points.is_empty() { Err(Error::NoPoints { place, advice }) } else { Ok(points) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn receivers_face_the_light_and_start_on_its_side() {
        let up = [0.0, 1.0, 0.0];
        let of = |facing| Receiver { p_world: [1.0, 2.0, 3.0], facing, lift_world: 0.5 };
        let (above, below) = ([0.6, 0.8, 0.0], [0.6, -0.8, 0.0]);
        let [space, front, both] = [Facing::Space, Facing::Front(up), Facing::Both(up)].map(of);
        assert_eq!([space.faces(above), space.faces(below)], [true, true]);
        assert_eq!(
            [front.faces(above), front.faces(below), front.faces([1.0, 0.0, 0.0])],
            [true, false, false]
        );
        assert_eq!(space.origin(1.0), [1.0, 2.0, 3.0]);
        assert_eq!([front.origin(1.0), both.origin(-1.0)], [[1.0, 2.5, 3.0], [1.0, 1.5, 3.0]]);
    }
}
