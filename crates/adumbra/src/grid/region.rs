//! Regions: squares that divide a world that is too wide for one file. `spec/adumbra-regions.md` has the
//! rules.

use super::LightGrid;
use super::vec3::dot;
use crate::error::{RangeError, RangeField};

/// A square of the columns of a world. All regions of a world have the same side, and region (0, 0) begins at
/// the world's origin. The file of a region has positions relative to the region's own origin, its middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(deny_unknown_fields))]
pub struct Region {
    /// Number along the grid's y.
    pub y: i32,
    /// Number along the grid's x.
    pub x: i32,
    /// Texels a side, at the finest level.
    pub texels: u32,
}

impl Region {
    /// Fewest and most texels a side of the regions into which a world is cut.
    const TEXELS: std::ops::RangeInclusive<u32> = 1 << 10..=1 << 17;

    /// Checks the texels a side of the regions into which a world is cut.
    ///
    /// # Errors
    /// Returns [`RangeError`] if they are not a power of two from 1024 to 131,072.
    pub fn check_texels(texels: u32) -> Result<(), RangeError> {
        if texels.is_power_of_two() && Self::TEXELS.contains(&texels) {
            return Ok(());
        }
        Err(RangeError::new(RangeField::RegionTexels, texels, "a power of two from 1024 to 131072"))
    }

    /// Returns the region of a point. Only the axes and the voxel size of `grid` are used, so it may be any
    /// grid of the world. A point that is not finite is in some region.
    pub fn containing(grid: &LightGrid, texels: u32, p_world: [f64; 3]) -> Self {
        let side = grid.voxel_size * f64::from(texels);
        let [x, y] = [0, 1].map(|a| (dot(grid.axes[a], p_world) / side).floor() as i32);
        Self { y, x, texels }
    }

    /// Returns the first texel along x and y, counted from the world's origin.
    pub fn first_texel(&self) -> [f64; 2] {
        [self.x, self.y].map(|n| f64::from(n) * f64::from(self.texels))
    }

    /// Returns the world position of the region's origin: the middle of its columns, where z is 0. Only the
    /// edges and the voxel size of `grid` are used. The voxel size must be that of the finest level.
    pub fn origin(&self, grid: &LightGrid) -> [f64; 3] {
        let half = 0.5 * f64::from(self.texels);
        let [x, y] = self.first_texel().map(|first| (first + half) * grid.voxel_size);
        // Adding 0.0 turns −0.0 into 0.0.
        std::array::from_fn(|a| grid.edges[0][a] * x + grid.edges[1][a] * y + 0.0)
    }

    /// Converts a grid of the world to the grid of the region's file, which is relative to the region's
    /// origin. `step` is the number of finest-level texels per texel of the grid, a power of two that divides
    /// half of the region's side.
    pub fn relative(&self, grid: LightGrid, step: u32) -> LightGrid {
        self.moved(grid, step, -1.0)
    }

    /// Converts a grid of the region's file to the world. It is the inverse of [`Region::relative`].
    pub fn in_world(&self, grid: LightGrid, step: u32) -> LightGrid {
        self.moved(grid, step, 1.0)
    }

    /// All numbers are whole, so nothing is rounded.
    fn moved(&self, mut grid: LightGrid, step: u32, way: f64) -> LightGrid {
        let half = 0.5 * f64::from(self.texels);
        for (corner, first) in grid.corner.iter_mut().zip(self.first_texel()) {
            *corner += way * (first + half) / f64::from(step);
        }
        grid
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{Frame, Sun};

    #[test]
    fn a_grid_relative_to_its_region_has_the_same_voxels() {
        let sun = Sun::from_angles(200.0, 30.0).unwrap();
        for frame in [Frame::Light, Frame::Oblique { yaw_radians: 0.7 }] {
            let world = LightGrid::new(sun, frame, 0.01, [512.0 * -9.0, 512.0 * 3.0, -512.0], [64, 64, 64]);
            for p in [[1000.0, 3.0, -7000.0], [-0.001, 0.0, -0.001], [5e4, -20.0, 3e4]] {
                let region = Region::containing(&world, 4096, p);
                let origin = region.origin(&world);
                let local: [f64; 3] = std::array::from_fn(|a| p[a] - origin[a]);
                for step in [1, 4, 16] {
                    let voxel_size = world.voxel_size * f64::from(step);
                    let grid = LightGrid { voxel_size, ..world };
                    let relative = region.relative(grid, step);
                    let (in_world, in_file) = (grid.to_grid(p), relative.to_grid(local));
                    assert!(
                        (0..3).all(|a| (in_world[a] - in_file[a]).abs() < 1e-6),
                        "{in_world:?} {in_file:?}"
                    );
                    assert_eq!(region.in_world(relative, step), grid);
                    let from_middle =
                        (0..2).map(|a| (in_file[a] + relative.corner[a]).abs() * f64::from(step));
                    assert!(
                        from_middle.fold(0.0, f64::max) <= 2048.0 + 1e-6,
                        "the point is not in its region"
                    );
                }
            }
        }
    }

    #[test]
    fn points_below_zero_are_in_regions_below_zero() {
        let sun = Sun::from_angles(0.0, 90.0).unwrap();
        let grid = LightGrid::new(sun, Frame::Oblique { yaw_radians: 0.0 }, 0.5, [0.0; 3], [8, 8, 8]);
        let at = |p| Region::containing(&grid, 1024, p);
        assert_eq!(at([-0.1, 0.0, 511.9]), Region { x: -1, y: 0, texels: 1024 });
        assert_eq!(at([512.0, 0.0, -513.0]), Region { x: 1, y: -2, texels: 1024 });
        assert_eq!(Region { x: 1, y: -2, texels: 1024 }.origin(&grid), [768.0, 0.0, -768.0]);
    }
}
