//! The light-aligned grid and its mapping to and from world space.
//!
//! In grid space, x and y count texels in the light's plane, and z counts voxels along the light, away from the sun.
//! Voxels are cubes. Voxel (i, j, k) spans [i, i+1) × [j, j+1) × [k, k+1). Source of the light-aligned space: Sintorn,
//! Kämpe, Olsson, Assarsson, *Compact Precomputed Voxelized Shadows*, 2014.

use super::vec3::{cross, dot, normalize};
use super::{Bounds, Sun};

/// The light-aligned grid of a bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightGrid {
    /// The sun that the grid is aligned with.
    pub sun: Sun,
    /// Edge length of a voxel in world units.
    pub voxel_size: f64,
    /// World position of the grid's corner (0, 0, 0).
    pub origin: [f64; 3],
    /// Unit axes of the grid in world space: x, y in the light's plane, z away from the sun. Right-handed.
    pub axes: [[f64; 3]; 3],
    /// Number of voxels along x, y and z. z may exceed the resolution if the scene is longer along the light than
    /// across it.
    pub size: [u32; 3],
}

impl LightGrid {
    /// Returns the smallest grid of voxels of `voxel_size` world units that covers `extent`, with a margin of one voxel
    /// before its nearest and behind its farthest point along the light.
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

    /// Converts a world point to grid coordinates.
    pub fn to_grid(self, p_world: [f64; 3]) -> [f64; 3] {
        let d = [p_world[0] - self.origin[0], p_world[1] - self.origin[1], p_world[2] - self.origin[2]];
        self.axes.map(|axis| dot(axis, d) / self.voxel_size)
    }

    /// Converts a grid point to world coordinates.
    pub fn to_world(self, p_grid: [f64; 3]) -> [f64; 3] {
        let mut p = self.origin;
        for (axis, c) in self.axes.iter().zip(p_grid) {
            for r in 0..3 {
                p[r] += axis[r] * c * self.voxel_size;
            }
        }
        p
    }

    /// Returns a world direction in the grid's axes, not scaled by the voxel size.
    pub fn direction_to_grid(&self, d_world: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| dot(axis, d_world))
    }

    /// Returns the affine map from world to grid as rows: `grid[r] = m[r][0..3] · world + m[r][3]`.
    pub fn grid_from_world(&self) -> [[f64; 4]; 3] {
        self.axes.map(|axis| {
            let s = axis.map(|c| c / self.voxel_size);
            [s[0], s[1], s[2], -dot(axis, self.origin) / self.voxel_size]
        })
    }
}

/// Extent of a set of points along the light's axes, in world units.
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
    /// Returns an empty extent along the axes of `sun`.
    pub fn empty(sun: &Sun) -> Self {
        Self { axes: light_axes(sun), min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] }
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

    /// Returns the longer side in the light's plane, in world units.
    pub fn longest_side(&self) -> f64 {
        (self.max[0] - self.min[0]).max(self.max[1] - self.min[1])
    }
}

/// Returns the light's axes, right-handed: z away from the sun, x horizontal, or +X if the sun is overhead.
fn light_axes(sun: &Sun) -> [[f64; 3]; 3] {
    let l = sun.towards();
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

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        (0..3).all(|i| (a[i] - b[i]).abs() < 1e-12)
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
