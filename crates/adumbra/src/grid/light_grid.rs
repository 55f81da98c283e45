//! The grid of a bake and its mapping to and from world space.
//!
//! In grid space, x and y count texels across the light, and z counts voxels along the light, away from the
//! sun. Voxel (i, j, k) spans [i, i+1) × [j, j+1) × [k, k+1). All points of a sun ray have the same x and y,
//! in either [`Frame`]. Source of the light-aligned space: Sintorn, Kämpe, Olsson, Assarsson, *Compact
//! Precomputed Voxelized Shadows*, 2014. The oblique frame is not in the paper.

use super::vec3::dot;
use super::{Bounds, Frame, Sun};

/// The grid of a bake: an affine map between the world and voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightGrid {
    /// The sun that the grid is aligned with.
    pub sun: Sun,
    /// Orientation of the grid in the world.
    pub frame: Frame,
    /// Edge length of a voxel, in world units: in the oblique frame that of its horizontal edges, and its
    /// height.
    pub voxel_size: f64,
    /// Grid position of the corner (0, 0, 0), in voxels from the world's origin: `axes · p / voxel_size` of
    /// that corner.
    pub corner: [f64; 3],
    /// Rows of the linear map from world to grid; see [`Frame::axes`].
    pub axes: [[f64; 3]; 3],
    /// Edges of a voxel in the world, in units of `voxel_size`; see [`Frame::edges`].
    pub edges: [[f64; 3]; 3],
    /// Number of voxels along x, y and z. z may exceed the resolution if the scene is longer along the light
    /// than across it.
    pub size: [u32; 3],
}

impl LightGrid {
    /// Creates a grid with its corner at `corner`, in voxels from the world's origin.
    pub fn new(sun: Sun, frame: Frame, voxel_size: f64, corner: [f64; 3], size: [u32; 3]) -> Self {
        let axes = frame.axes(&sun);
        Self { sun, frame, voxel_size, corner, axes, edges: frame.edges(&sun, &axes), size }
    }

    /// Returns the smallest grid of voxels of `voxel_size` world units that covers `extent`, with a margin of
    /// one voxel before its nearest and behind its farthest point along the light.
    pub fn covering(sun: Sun, extent: &LightExtent, voxel_size: f64) -> Self {
        let margin = |axis: usize| if axis == 2 { 1.0 } else { 0.0 };
        let corner: [f64; 3] = std::array::from_fn(|a| extent.min[a] / voxel_size - margin(a));
        let size = std::array::from_fn(|a| {
            let cells = (extent.max[a] - extent.min[a]) / voxel_size + 2.0 * margin(a);
            (cells - 1e-6).ceil().clamp(1.0, 4_294_967_000.0) as u32
        });
        Self::new(sun, extent.frame, voxel_size, corner, size)
    }

    /// Returns the smallest grid that contains this one and begins and ends at multiples of `step` voxels
    /// from the world's origin. Such grids of one sun, frame and voxel size share their voxels, whatever they
    /// cover.
    #[must_use]
    pub fn snapped_to(self, step: u32) -> Self {
        let step = f64::from(step);
        let (mut corner, mut size) = (self.corner, self.size);
        for a in 0..3 {
            // Rounding must not add a step: allow 1e-6 of a voxel at both ends.
            let first = ((corner[a] + 1e-6) / step).floor();
            let end = ((corner[a] + f64::from(size[a]) - 1e-6) / step).ceil();
            corner[a] = first * step;
            size[a] = ((end - first).max(1.0) * step).min(4_294_967_000.0) as u32;
        }
        Self { corner, size, ..self }
    }

    /// Returns the world position of the corner (0, 0, 0).
    pub fn origin(&self) -> [f64; 3] {
        self.to_world([0.0; 3])
    }

    /// Converts a world point to grid coordinates.
    pub fn to_grid(self, p_world: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| dot(self.axes[a], p_world) / self.voxel_size - self.corner[a])
    }

    /// Converts a grid point to world coordinates.
    pub fn to_world(self, p_grid: [f64; 3]) -> [f64; 3] {
        let mut p = [0.0; 3];
        for ((c, corner), edge) in p_grid.into_iter().zip(self.corner).zip(self.edges) {
            let along = (c + corner) * self.voxel_size;
            for (p, edge) in p.iter_mut().zip(edge) {
                *p += edge * along;
            }
        }
        p
    }

    /// Returns a world direction in the grid, not scaled by the voxel size.
    pub fn direction_to_grid(&self, d_world: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| dot(axis, d_world))
    }

    /// Returns the normal in the grid of a plane with this normal in the world. Its length is different.
    pub fn normal_to_grid(&self, normal_world: [f64; 3]) -> [f64; 3] {
        self.edges.map(|edge| dot(edge, normal_world))
    }

    /// Returns the rows of the map from the unit circle across the light to the ellipse, in grid x and y,
    /// whose points are on the same sun rays. It is the identity in the light's frame. In the oblique frame
    /// the ellipse is longer along the sun's compass direction. Do not call it on a placed grid, where Y may
    /// not be up.
    pub fn circle_across_light(&self) -> [[f64; 2]; 2] {
        let [sx, sy, sz] = self.sun.towards();
        let flat = (sx * sx + sz * sz).sqrt();
        if self.frame == Frame::Light || flat == 0.0 {
            return [[1.0, 0.0], [0.0, 1.0]];
        }
        // The sun's compass direction in the grid: horizontal vectors have the same length in both.
        let [hx, hy, _] = self.direction_to_grid([sx / flat, 0.0, sz / flat]);
        let longer = 1.0 / sy - 1.0;
        [[1.0 + longer * hx * hx, longer * hx * hy], [longer * hx * hy, 1.0 + longer * hy * hy]]
    }

    /// Returns the length in the world of one voxel along the light.
    pub fn voxel_along_light(&self) -> f64 {
        let edge = self.edges[2];
        dot(edge, edge).sqrt() * self.voxel_size
    }

    /// Returns by how many texels the radius of the cone of a sun with this full angle grows per voxel of
    /// depth.
    pub fn cone_texels_per_voxel(&self, sun_degrees: f64) -> f64 {
        libm::tan((0.5 * sun_degrees).to_radians()) * self.voxel_along_light() / self.voxel_size
    }
}

/// Extent of a set of points along the axes of a grid, in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightExtent {
    /// Orientation of the axes in the world.
    pub frame: Frame,
    /// The axes, see [`Frame::axes`].
    pub axes: [[f64; 3]; 3],
    /// Smallest coordinate along each axis.
    pub min: [f64; 3],
    /// Largest coordinate along each axis.
    pub max: [f64; 3],
}

impl LightExtent {
    /// Returns an empty extent along the axes of the light.
    pub fn empty(sun: &Sun) -> Self {
        Self::in_frame(sun, Frame::Light)
    }

    /// Returns an empty extent along the axes of a frame.
    pub fn in_frame(sun: &Sun, frame: Frame) -> Self {
        Self { frame, axes: frame.axes(sun), min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] }
    }

    /// Grows the extent to contain `p_world`.
    pub fn add(&mut self, p_world: [f64; 3]) {
        for a in 0..3 {
            let c = dot(self.axes[a], p_world);
            self.min[a] = self.min[a].min(c);
            self.max[a] = self.max[a].max(c);
        }
    }

    /// Grows the extent to contain all eight corners of `bounds`.
    pub fn add_box(&mut self, bounds: &Bounds) {
        for corner in 0..8_usize {
            let pick = |a: usize| if corner >> a & 1 == 0 { bounds.min[a] } else { bounds.max[a] };
            self.add([pick(0), pick(1), pick(2)]);
        }
    }

    /// Returns the extent of both sets of points. They must be along the same axes.
    pub fn joined(mut self, other: &Self) -> Self {
        for a in 0..3 {
            self.min[a] = self.min[a].min(other.min[a]);
            self.max[a] = self.max[a].max(other.max[a]);
        }
        self
    }

    /// Returns the longer side across the light, in world units.
    pub fn longest_side(&self) -> f64 {
        (self.max[0] - self.min[0]).max(self.max[1] - self.min[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::vec3::{cross, normalize};

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        (0..3).all(|i| (a[i] - b[i]).abs() < 1e-12)
    }

    const FRAMES: [Frame; 3] =
        [Frame::Light, Frame::Oblique { yaw_radians: 0.0 }, Frame::Oblique { yaw_radians: 0.7 }];

    fn city_grid(sun: Sun, frame: Frame) -> LightGrid {
        let mut extent = LightExtent::in_frame(&sun, frame);
        extent.add_box(&Bounds { min: [-3.0, 0.0, 5.0], max: [40.0, 7.0, 9.0] });
        LightGrid::covering(sun, &extent, extent.longest_side() / 64.0)
    }

    #[test]
    fn grid_axes_are_right_handed_and_points_round_trip() {
        for (azimuth, elevation) in [(0.0, 90.0), (31.0, 89.999_999), (200.0, 3.0), (310.0, 40.0)] {
            let sun = Sun::from_angles(azimuth, elevation).unwrap();
            for frame in FRAMES {
                let grid = city_grid(sun, frame);
                assert!(dot(cross(grid.axes[0], grid.axes[1]), grid.axes[2]) > 0.0);
                assert_eq!(grid.size[0].max(grid.size[1]), 64);
                let p = [12.0, 3.0, 6.5];
                let p_grid = grid.to_grid(p);
                assert!((0..3).all(|a| p_grid[a] > 0.0 && p_grid[a] < f64::from(grid.size[a])));
                let back = grid.to_world(p_grid);
                assert!((0..3).all(|a| (back[a] - p[a]).abs() < 1e-9), "{frame:?} {back:?}");
                let along_light = grid.to_world([p_grid[0], p_grid[1], p_grid[2] - 1.0]);
                let step = sun.towards().map(|c| c * grid.voxel_along_light());
                assert!((0..3).all(|a| (along_light[a] - p[a] - step[a]).abs() < 1e-9), "{frame:?}");
            }
            let light = city_grid(sun, Frame::Light);
            assert!(near(light.axes[2], sun.towards().map(|c| -c)));
            assert!(near(cross(light.axes[0], light.axes[1]), light.axes[2]));
        }
    }

    #[test]
    fn normals_stay_perpendicular_to_their_planes() {
        let sun = Sun::from_angles(310.0, 40.0).unwrap();
        let (along, across) = ([1.0, 0.25, -0.5], [0.3, -2.0, 0.1]);
        for frame in FRAMES {
            let grid = city_grid(sun, frame);
            let n = grid.normal_to_grid(cross(along, across));
            for d in [along, across] {
                assert!(dot(n, grid.direction_to_grid(d)).abs() < 1e-12, "{frame:?}");
            }
        }
    }

    #[test]
    fn circle_across_light_maps_to_ellipse_in_grid() {
        for (azimuth, elevation) in [(0.0, 90.0), (31.0, 20.0), (200.0, 60.0)] {
            let sun = Sun::from_angles(azimuth, elevation).unwrap();
            // Two unit vectors that are perpendicular to the light and to each other.
            let across = normalize(cross(sun.towards(), [1.0, 0.0, 0.0]));
            let along = cross(sun.towards(), across);
            for frame in FRAMES {
                let grid = city_grid(sun, frame);
                let [[a, b], [c, d]] = grid.circle_across_light();
                for degrees in [0.0, 40.0, 80.0, 120.0, 160.0_f64] {
                    let (sine, cosine) = degrees.to_radians().sin_cos();
                    let on_circle: [f64; 3] = std::array::from_fn(|i| cosine * across[i] + sine * along[i]);
                    let [x, y, _] = grid.direction_to_grid(on_circle);
                    // The point of the ellipse, mapped back to the unit circle.
                    let from = [(d * x - b * y) / (a * d - b * c), (a * y - c * x) / (a * d - b * c)];
                    let radius = from[0].hypot(from[1]);
                    assert!((radius - 1.0).abs() < 1e-9, "{frame:?}, {azimuth}, {degrees}: {radius}");
                }
            }
        }
    }

    #[test]
    fn snapped_grids_share_their_voxels() {
        let sun = Sun::from_angles(200.0, 30.0).unwrap();
        for frame in FRAMES {
            let [small, large] = [[5.0, 2.0, 9.0], [5000.0, 90.0, 1234.5]].map(|max| {
                let mut extent = LightExtent::in_frame(&sun, frame);
                extent.add_box(&Bounds { min: [-1.0, 0.0, -3.0], max });
                LightGrid::covering(sun, &extent, 0.25).snapped_to(64)
            });
            for grid in [small, large] {
                let whole = |c: f64| c % 64.0 == 0.0;
                assert!(grid.corner.into_iter().chain(grid.size.map(f64::from)).all(whole), "{grid:?}");
            }
            let p = [3.1, 0.4, 7.7];
            let apart: [f64; 3] = std::array::from_fn(|a| large.corner[a] - small.corner[a]);
            let (p_small, p_large) = (small.to_grid(p), large.to_grid(p));
            assert!((0..3).all(|a| (p_small[a] - p_large[a] - apart[a]).abs() < 1e-9), "{frame:?}");
        }
    }
}
