//! The sun and the light-aligned grid: world <-> grid.
//!
//! Grid space: x and y count texels in the light's plane, z counts voxels along the light, away from the sun; voxels
//! are cubes. Voxel (i, j, k) spans [i, i+1) × [j, j+1) × [k, k+1). Source: Sintorn, Kämpe, Olsson, Assarsson,
//! *Compact Precomputed Voxelized Shadows*, 2014, for the light-aligned space.
//!
//! Every figure is made with additions, products, quotients and square roots of `f64`, and `libm`'s sine and cosine,
//! so that machines agree to the last bit.

mod camera;

pub use camera::{LightCamera, Matrix};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::scene::Bounds;

/// A directional light: the unit vector towards the sun.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sun {
    towards: [f64; 3],
}

impl Sun {
    /// A sun in the direction `towards` (any length).
    ///
    /// # Errors
    /// [`Error::SunDirection`] for a zero or not finite vector, [`Error::SunBelowHorizon`] where y <= 0.
    pub fn from_direction(towards: [f64; 3]) -> Result<Self> {
        let largest = towards.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        if !towards.iter().all(|c| c.is_finite()) || largest == 0.0 {
            return Err(Error::SunDirection { direction: towards });
        }
        let scaled = towards.map(|c| c / largest);
        let unit = normalize(scaled);
        if unit[1] <= 0.0 {
            let elevation_degrees = libm::asin(unit[1]).to_degrees();
            return Err(Error::SunBelowHorizon { elevation_degrees });
        }
        Ok(Self { towards: unit })
    }

    /// A sun by compass: `azimuth` in degrees clockwise from -Z seen from above (90° is +X), `elevation` in degrees
    /// above the horizon.
    ///
    /// # Errors
    /// As [`Sun::from_direction`]; an elevation above 90° is [`Error::OptionRange`].
    pub fn from_angles(azimuth_degrees: f64, elevation_degrees: f64) -> Result<Self> {
        if !azimuth_degrees.is_finite() || !elevation_degrees.is_finite() || elevation_degrees > 90.0 {
            return Err(Error::OptionRange {
                option: "--elevation",
                value: format!("{elevation_degrees} (azimuth {azimuth_degrees})"),
                range: "above 0 and at most 90 degrees, with a finite azimuth",
            });
        }
        if elevation_degrees <= 0.0 {
            return Err(Error::SunBelowHorizon { elevation_degrees });
        }
        let (azimuth, elevation) = (azimuth_degrees.to_radians(), elevation_degrees.to_radians());
        let flat = if elevation_degrees == 90.0 { 0.0 } else { libm::cos(elevation) };
        Self::from_direction([flat * libm::sin(azimuth), libm::sin(elevation), -flat * libm::cos(azimuth)])
    }

    /// Unit vector towards the sun, world space.
    pub fn towards(&self) -> [f64; 3] {
        self.towards
    }

    /// Elevation above the horizon in degrees.
    pub fn elevation_degrees(&self) -> f64 {
        libm::asin(self.towards[1].min(1.0)).to_degrees()
    }
}

/// The light-aligned grid of a bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightGrid {
    /// The sun that it is aligned with.
    pub sun: Sun,
    /// Edge of a voxel in world units.
    pub voxel_size: f64,
    /// World position of the grid's corner (0, 0, 0).
    pub origin: [f64; 3],
    /// Unit axes of the grid in world space: x, y in the light's plane, z away from the sun. Right-handed.
    pub axes: [[f64; 3]; 3],
    /// Voxels along x, y and z; z may exceed the resolution where the scene is longer along the light than across.
    pub size: [u32; 3],
}

impl LightGrid {
    /// The grid of voxels of `voxel_size` world units that just covers `extent`, with one voxel of margin before its
    /// nearest and behind its farthest point along the light.
    pub fn covering(sun: Sun, extent: &LightExtent, voxel_size: f64) -> Self {
        let e = extent;
        let mut size = [0; 3];
        let mut corner = [0.0; 3];
        for a in 0..3 {
            let margin = if a == 2 { voxel_size } else { 0.0 };
            corner[a] = e.min[a] - margin;
            let cells = ((e.max[a] - e.min[a] + 2.0 * margin) / voxel_size - 1e-6).ceil();
            size[a] = cells.clamp(1.0, 4_294_967_000.0) as u32;
        }
        let mut origin = [0.0; 3];
        for (r, o) in origin.iter_mut().enumerate() {
            *o = e.axes[0][r] * corner[0] + e.axes[1][r] * corner[1] + e.axes[2][r] * corner[2];
        }
        Self { sun, voxel_size, origin, axes: e.axes, size }
    }

    /// A world point in grid coordinates.
    pub fn to_grid(self, p_world: [f64; 3]) -> [f64; 3] {
        let d = [p_world[0] - self.origin[0], p_world[1] - self.origin[1], p_world[2] - self.origin[2]];
        self.axes.map(|axis| dot(axis, d) / self.voxel_size)
    }

    /// A grid point in world coordinates.
    pub fn to_world(self, p_grid: [f64; 3]) -> [f64; 3] {
        let mut p = self.origin;
        for (axis, c) in self.axes.iter().zip(p_grid) {
            for r in 0..3 {
                p[r] += axis[r] * c * self.voxel_size;
            }
        }
        p
    }

    /// A world direction in the grid's axes (not scaled).
    pub fn direction_to_grid(&self, d_world: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| dot(axis, d_world))
    }

    /// `grid_from_world` as rows of an affine map: `grid[r] = m[r][0..3] · world + m[r][3]`.
    pub fn grid_from_world(&self) -> [[f64; 4]; 3] {
        self.axes.map(|axis| {
            let s = axis.map(|c| c / self.voxel_size);
            [s[0], s[1], s[2], -dot(axis, self.origin) / self.voxel_size]
        })
    }
}

/// What a set of points covers along the light's axes, in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightExtent {
    /// Unit axes: x, y in the light's plane, z away from the sun.
    pub axes: [[f64; 3]; 3],
    /// Smallest coordinate along each axis.
    pub min: [f64; 3],
    /// Largest coordinate along each axis.
    pub max: [f64; 3],
}

impl LightExtent {
    /// An empty extent along the axes of `sun`.
    pub fn empty(sun: &Sun) -> Self {
        Self { axes: light_axes(sun), min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] }
    }

    /// Grows to hold `p_world`.
    pub fn add(&mut self, p_world: [f64; 3]) {
        for a in 0..3 {
            let c = dot(self.axes[a], p_world);
            self.min[a] = self.min[a].min(c);
            self.max[a] = self.max[a].max(c);
        }
    }

    /// Grows to hold all eight corners of `bounds`.
    pub fn add_box(&mut self, bounds: &Bounds) {
        for corner in 0..8_usize {
            let pick = |a: usize| if corner >> a & 1 == 0 { bounds.min[a] } else { bounds.max[a] };
            self.add([pick(0), pick(1), pick(2)]);
        }
    }

    /// The longer side in the light's plane, world units.
    pub fn longest_side(&self) -> f64 {
        (self.max[0] - self.min[0]).max(self.max[1] - self.min[1])
    }
}

/// The light's axes: z away from the sun; x horizontal, or +X where the sun is overhead; right-handed.
fn light_axes(sun: &Sun) -> [[f64; 3]; 3] {
    let l = sun.towards;
    let z = l.map(|c| -c);
    let flat = (l[0] * l[0] + l[2] * l[2]).sqrt();
    let x = if flat < 1e-9 { [1.0, 0.0, 0.0] } else { [l[2] / flat, 0.0, -l[0] / flat] };
    let x = normalize(sub_projection(x, z));
    let y = cross(z, x);
    [x, y, z]
}

fn sub_projection(v: [f64; 3], unit: [f64; 3]) -> [f64; 3] {
    let d = dot(v, unit);
    [v[0] - d * unit[0], v[1] - d * unit[1], v[2] - d * unit[2]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn normalize(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        (0..3).all(|i| (a[i] - b[i]).abs() < 1e-12)
    }

    #[test]
    fn sun_angles_run_clockwise_from_minus_z() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert!(near(Sun::from_angles(0.0, 45.0).unwrap().towards(), [0.0, half, -half]));
        assert!(near(Sun::from_angles(90.0, 45.0).unwrap().towards(), [half, half, 0.0]));
        assert!(near(Sun::from_angles(-90.0, 45.0).unwrap().towards(), [-half, half, 0.0]));
        assert_eq!(Sun::from_angles(123.0, 90.0).unwrap().towards(), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn sun_refuses_what_gives_no_light_from_above() {
        for direction in [[0.0; 3], [f64::NAN, 1.0, 0.0], [f64::INFINITY, 1.0, 0.0]] {
            assert!(
                matches!(Sun::from_direction(direction), Err(Error::SunDirection { .. })),
                "{direction:?}"
            );
        }
        for direction in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]] {
            assert!(
                matches!(Sun::from_direction(direction), Err(Error::SunBelowHorizon { .. })),
                "{direction:?}"
            );
        }
        assert!(matches!(Sun::from_angles(0.0, -0.5), Err(Error::SunBelowHorizon { .. })));
        assert!(matches!(Sun::from_angles(0.0, 90.5), Err(Error::OptionRange { .. })));
        // Lengths do not matter, even those whose squares leave the range.
        assert_eq!(Sun::from_direction([0.0, 1e-300, 0.0]).unwrap().towards(), [0.0, 1.0, 0.0]);
        assert_eq!(Sun::from_direction([0.0, 1e300, 0.0]).unwrap().towards(), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn grid_is_a_right_handed_frame_that_maps_there_and_back() {
        for (azimuth, elevation) in [(0.0, 90.0), (31.0, 89.999_999), (200.0, 3.0), (310.0, 40.0)] {
            let sun = Sun::from_angles(azimuth, elevation).unwrap();
            let mut extent = LightExtent::empty(&sun);
            extent.add_box(&Bounds { min: [-3.0, 0.0, 5.0], max: [40.0, 7.0, 9.0] });
            let grid = LightGrid::covering(sun, &extent, extent.longest_side() / 64.0);
            assert!(near(cross(grid.axes[0], grid.axes[1]), grid.axes[2]));
            assert!(near(grid.axes[2], sun.towards().map(|c| -c)));
            assert_eq!(grid.size[0].max(grid.size[1]), 64);
            let p = [12.0, 3.0, 6.5];
            let p_grid = grid.to_grid(p);
            assert!((0..3).all(|a| p_grid[a] > 0.0 && p_grid[a] < f64::from(grid.size[a])));
            let back = grid.to_world(p_grid);
            assert!((0..3).all(|a| (back[a] - p[a]).abs() < 1e-9));
            let rows = grid.grid_from_world();
            let mapped = rows.map(|r| r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3]);
            assert!((0..3).all(|a| (mapped[a] - p_grid[a]).abs() < 1e-9));
        }
    }
}
