//! The cell size of a tree in plan. The regions are cut at all their edges into rectangles of one level each,
//! so that a look-up, here or in a shader, searches a small table instead of the regions.

use crate::tree::space::{Regions, TreeSpace};

/// The levels of a tree's cells by rectangle of the plan. At level n a cell has sides of 2^n voxels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanLevels {
    edges: [Vec<u32>; 2],
    levels: Vec<u8>,
}

impl PlanLevels {
    /// Builds the rectangles of `regions` on `space`. At each point the deepest region that contains it
    /// counts.
    pub fn new(space: &TreeSpace, regions: &Regions) -> Self {
        let list = regions.in_voxels(space);
        let side = space.side_voxels();
        let inner_edges = |pick: fn(&crate::tree::RegionVoxels) -> [u32; 2]| {
            let mut edges: Vec<u32> = list.iter().flat_map(pick).filter(|e| (1..side).contains(e)).collect();
            edges.sort_unstable();
            edges.dedup();
            edges
        };
        let edges = [inner_edges(|r| r.x), inner_edges(|r| r.z)];
        let columns = edges[0].len() + 1;
        let base = space.depth - regions.base_depth;
        let mut levels = vec![base as u8; columns * (edges[1].len() + 1)];
        // Shallow regions first, so that deeper ones overwrite them.
        for region in list.iter().rev() {
            let level = base.min(space.depth - region.depth) as u8;
            let cells = |axis: usize, [from, to]: [u32; 2]| {
                let place = |e: u32| edges[axis].partition_point(|edge| *edge <= e);
                place(from)..place(to - 1) + 1
            };
            for z in cells(1, region.z) {
                let row = &mut levels[z * columns..][..columns];
                row[cells(0, region.x)].fill(level);
            }
        }
        Self { edges, levels }
    }

    /// Boundaries between rectangles in voxels, ascending: along x, along z. The faces of the cube are not
    /// included.
    pub fn edges(&self) -> [&[u32]; 2] {
        [&self.edges[0], &self.edges[1]]
    }

    /// One level per rectangle, x fastest.
    pub fn levels(&self) -> &[u8] {
        &self.levels
    }

    /// Returns the level of the coarsest cells that the range `x[0]..=x[1]`, `z[0]..=z[1]`, in voxels,
    /// touches. Outside the cube, the level at its border applies.
    pub(crate) fn coarsest_over(&self, x: [f64; 2], z: [f64; 2]) -> u32 {
        let cells = |axis: usize, range: [f64; 2]| {
            let place = |c: f64| self.edges[axis].partition_point(|edge| f64::from(*edge) <= c);
            place(range[0])..=place(range[1])
        };
        let columns = self.edges[0].len() + 1;
        let rows = cells(1, z).map(|row| &self.levels[row * columns..][..columns]);
        let coarsest = rows.flat_map(|row| &row[cells(0, x)]).max();
        coarsest.map_or(0, |level| u32::from(*level))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::Region;
    use adumbra_scene::random::Random;

    #[test]
    fn plan_levels_are_those_of_the_deepest_region() {
        let space = TreeSpace { p_min: [0.0; 3], voxel_size: 1.0, depth: 6 };
        let mut random = Random::new(5, 0);
        for count in 0..9 {
            let mut range = || {
                let [a, b] = [0, 0].map(|_| (random.unit() * 80.0 - 8.0).floor());
                [a.min(b), a.max(b) + 1.0]
            };
            let list = (0..count).map(|i| Region { x: range(), z: range(), depth: 3 + i % 4 }).collect();
            let regions = Regions { base_depth: 4, list };
            let plan = PlanLevels::new(&space, &regions);
            let depth_at = |x: f64, z: f64| {
                let holds = |r: &&Region| r.x[0] <= x && x < r.x[1] && r.z[0] <= z && z < r.z[1];
                regions.list.iter().filter(holds).map(|r| r.depth).fold(4, u32::max)
            };
            for _ in 0..200 {
                let [x, z] = [0, 0].map(|_| (random.unit() * 64.0).floor());
                let [to_x, to_z] = [x, z].map(|c| (c + (random.unit() * 9.0).floor()).min(63.0));
                let mut shallowest = u32::MAX;
                for i in x as u32..=to_x as u32 {
                    for k in z as u32..=to_z as u32 {
                        shallowest = shallowest.min(depth_at(i.into(), k.into()));
                    }
                }
                let coarsest = plan.coarsest_over([x, to_x + 0.9], [z, to_z + 0.5]);
                assert_eq!(coarsest, 6 - shallowest, "{regions:?} {x} {z} {to_x} {to_z}");
            }
        }
    }
}
