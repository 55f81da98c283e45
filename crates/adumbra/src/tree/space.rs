//! Where a tree lies in the world, and how deep it goes where.

use serde::{Deserialize, Serialize};

use super::MAX_DEPTH;
use crate::error::{Error, Result};

/// The cube that a tree divides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeSpace {
    /// World position of its lowest corner: p_min of (3-4).
    pub p_min: [f64; 3],
    /// Edge of a voxel, world units.
    pub voxel_size: f64,
    /// Levels: 2^depth voxels a side.
    pub depth: u32,
}

impl TreeSpace {
    /// Voxels a side.
    pub fn side_voxels(&self) -> u32 {
        1 << self.depth
    }

    /// A world point in voxels from the cube's lowest corner: p' = p - p_min (3-4), in voxels.
    pub fn to_tree(self, p_world: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| (p_world[a] - self.p_min[a]) / self.voxel_size)
    }

    /// A point in voxels from the lowest corner as a world point.
    pub fn to_world(self, p_tree: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.p_min[a] + p_tree[a] * self.voxel_size)
    }
}

/// A box in plan in which the tree goes down to a depth of its own, at all heights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// World x from, to.
    pub x: [f64; 2],
    /// World z from, to.
    pub z: [f64; 2],
    /// Levels there.
    pub depth: u32,
}

/// How deep a tree goes where: the base, and regions that go deeper. The deepest that holds a point counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Regions {
    /// Levels outside all regions.
    pub base_depth: u32,
    /// Deeper parts.
    pub list: Vec<Region>,
}

/// A region on the voxel grid: from (included) and to (excluded).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RegionVoxels {
    /// Voxels along x.
    pub x: [u32; 2],
    /// Voxels along z.
    pub z: [u32; 2],
    /// Levels there.
    pub depth: u32,
}

/// Most regions of a tree.
pub const MAX_REGIONS: usize = 256;

impl Regions {
    /// One depth everywhere.
    pub fn uniform(depth: u32) -> Self {
        Self { base_depth: depth, list: Vec::new() }
    }

    /// Nested squares around a point, as cascades: `depth` within the first radius, one level less in each next one,
    /// one less again outside the last.
    pub fn rings(center_xz: [f64; 2], radii: &[f64], depth: u32) -> Self {
        let around = |c: f64, r: f64| [c - r, c + r];
        let list = (0..).zip(radii).map(|(i, &r)| Region {
            x: around(center_xz[0], r),
            z: around(center_xz[1], r),
            depth: depth.saturating_sub(i),
        });
        Self { base_depth: depth.saturating_sub(radii.len() as u32), list: list.collect() }
    }

    /// The regions on the voxels of `space`, grown to whole voxels, deepest first; those outside the cube are left out.
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

    /// Levels of the deepest part.
    pub fn depth(&self) -> u32 {
        self.list.iter().map(|r| r.depth).fold(self.base_depth, u32::max)
    }

    /// Whether every depth is from 1 to [`MAX_DEPTH`], every box is finite and not empty, and they are at most
    /// [`MAX_REGIONS`].
    ///
    /// # Errors
    /// [`Error::OptionRange`] with the first that is not.
    pub fn check(&self) -> Result<()> {
        let refuse = |value: String, range| Err(Error::OptionRange { option: "--region", value, range });
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
