//! The cube of a tree in the world, and its depth in each part of the plan.

use serde::{Deserialize, Serialize};

use crate::tree::error::{OptionError, TreeOption};
use crate::tree::word::MAX_DEPTH;

/// The cube that a tree subdivides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeSpace {
    /// World position of its lowest corner: p_min of (3-4).
    pub p_min: [f64; 3],
    /// Edge of a voxel in world units.
    pub voxel_size: f64,
    /// Number of levels; a side has 2^depth voxels.
    pub depth: u32,
}

impl TreeSpace {
    /// Voxels along a side.
    pub fn side_voxels(&self) -> u32 {
        1 << self.depth
    }

    /// Converts a world point to voxels from the lowest corner of the cube: p' = p - p_min (3-4), divided by
    /// the voxel size.
    pub fn to_tree(self, p_world: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| (p_world[a] - self.p_min[a]) / self.voxel_size)
    }

    /// Converts a point in voxels from the lowest corner to a world point.
    pub fn to_world(self, p_tree: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.p_min[a] + p_tree[a] * self.voxel_size)
    }
}

/// A rectangle in plan, at all heights, in which the tree has its own depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// World x range: from, to.
    pub x: [f64; 2],
    /// World z range: from, to.
    pub z: [f64; 2],
    /// Number of levels in the region.
    pub depth: u32,
}

/// The depth of a tree in each part of the plan: a base depth, and regions that are deeper. At each point the
/// deepest region that contains it counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Regions {
    /// Number of levels outside all regions.
    pub base_depth: u32,
    /// The deeper regions.
    pub list: Vec<Region>,
}

/// A region on the voxel grid, as half-open ranges: from (included) and to (excluded).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegionVoxels {
    /// Range of voxels along x.
    pub x: [u32; 2],
    /// Range of voxels along z.
    pub z: [u32; 2],
    /// Number of levels in the region.
    pub depth: u32,
}

/// Maximum number of regions of a tree.
pub const MAX_REGIONS: usize = 256;

impl Regions {
    /// Returns one depth for the whole plan.
    pub fn uniform(depth: u32) -> Self {
        Self { base_depth: depth, list: Vec::new() }
    }

    /// Returns nested squares around a point, like cascades: `depth` within the first radius, one level less
    /// in each further square, and one less again outside the last.
    pub fn rings(center_xz: [f64; 2], radii: &[f64], depth: u32) -> Self {
        let around = |c: f64, r: f64| [c - r, c + r];
        let list = (0..).zip(radii).map(|(i, &r)| Region {
            x: around(center_xz[0], r),
            z: around(center_xz[1], r),
            depth: depth.saturating_sub(i),
        });
        Self { base_depth: depth.saturating_sub(radii.len() as u32), list: list.collect() }
    }

    /// Returns the regions in voxels of `space`, expanded to whole voxels, deepest first. Regions outside the
    /// cube are omitted.
    pub fn in_voxels(&self, space: &TreeSpace) -> Vec<RegionVoxels> {
        let side = f64::from(space.side_voxels());
        let range = |a: usize, r: [f64; 2]| {
            let to_voxels = |c: f64| (c - space.p_min[a]) / space.voxel_size;
            let [from, to] = [to_voxels(r[0]).floor(), to_voxels(r[1]).ceil()];
            [from.clamp(0.0, side) as u32, to.clamp(0.0, side) as u32]
        };
        let mut list: Vec<_> = self
            .list
            .iter()
            .map(|r| RegionVoxels { x: range(0, r.x), z: range(2, r.z), depth: r.depth })
            .filter(|r| r.x[0] < r.x[1] && r.z[0] < r.z[1])
            .collect();
        list.sort_by_key(|r| std::cmp::Reverse(r.depth));
        list
    }

    /// Number of levels of the deepest part.
    pub fn depth(&self) -> u32 {
        self.list.iter().map(|r| r.depth).fold(self.base_depth, u32::max)
    }

    /// Checks that every depth is from 1 to [`MAX_DEPTH`], that every rectangle is finite and not empty, and
    /// that there are at most [`MAX_REGIONS`] regions.
    ///
    /// # Errors
    /// Returns [`OptionError`] for the first violation.
    pub fn check(&self) -> Result<(), OptionError> {
        let refuse = |value: String, range| Err(OptionError::new(TreeOption::Region, value, range));
        if self.list.len() > MAX_REGIONS {
            return refuse(format!("{} regions", self.list.len()), "at most 256 of them");
        }
        for depth in self.list.iter().map(|r| r.depth).chain([self.base_depth]) {
            if !(1..=MAX_DEPTH).contains(&depth) {
                return refuse(format!("a depth of {depth}"), "depths from 1 to 15");
            }
        }
        for r in &self.list {
            for [low, high] in [r.x, r.z] {
                if !(low.is_finite() && high.is_finite() && low < high) {
                    return refuse(format!("{low} to {high}"), "finite numbers, the lower one first");
                }
            }
        }
        Ok(())
    }
}
