//! The root blocks of the light's plane, and the inputs for building each one. Both builders share them.

use adumbra::LightGrid;
use adumbra_scene::Instance;
use rayon::prelude::*;

use crate::columns::capture::TexelRect;
use crate::columns::limit::SwitchLimit;
use crate::columns::rules::ColumnRules;
use crate::triangles::casters::Casters;
use crate::triangles::corners::{Corner, Corners};

/// A scene divided into root blocks.
pub(crate) struct RootBlocks<'s> {
    pub(crate) grid: LightGrid,
    pub(crate) rules: ColumnRules,
    pub(crate) limit: SwitchLimit,
    pub(crate) casters: Casters<'s>,
    /// A root block is 2^root_level texels a side. In depth, it is divided into cubes of that side.
    pub(crate) root_level: u32,
    /// Number of those cubes along x, y, z.
    pub(crate) top_dims: [u32; 3],
}

impl RootBlocks<'_> {
    /// Returns the number of root blocks; they are ordered with x fastest.
    pub(crate) fn count(&self) -> usize {
        (self.top_dims[0] * self.top_dims[1]) as usize
    }

    /// Returns `samples` root blocks spread evenly from the emptiest to the fullest, in the order of
    /// `fullness`. There must be at least as many blocks.
    pub(crate) fn sampled(
        &self,
        samples: usize,
        fullness: impl Fn(usize) -> u64,
    ) -> impl Iterator<Item = usize> {
        let blocks = self.count();
        let mut by_fullness: Vec<usize> = (0..blocks).collect();
        by_fullness.sort_by_key(|&block| fullness(block));
        // The middle block of each of `samples` equal runs.
        (0..samples).map(move |s| by_fullness[(2 * s + 1) * blocks / (2 * samples)])
    }

    /// Returns the number of corners of casting triangles over each root block. The order of triangles does
    /// not matter.
    ///
    /// Cost: one pass over the vertices of all instances.
    pub(crate) fn corners_over(&self, corners: &Corners) -> Vec<u64> {
        let [nx, ny] = [self.top_dims[0], self.top_dims[1]].map(f64::from);
        let side = f64::from(1_u32 << self.root_level);
        let scene = self.casters.scene;
        let none = || vec![0; self.count()];
        let casting: Vec<&Instance> = scene.instances.iter().filter(|i| i.casts).collect();
        let count = |mut counts: Vec<u64>, instance: &&Instance| {
            for &Corner { position, count } in corners.of(instance) {
                let [x, y, _] = self.grid.to_grid(instance.to_world(position));
                let [x, y] = [x, y].map(|c| (c / side).floor());
                if (0.0..nx).contains(&x) && (0.0..ny).contains(&y) {
                    counts[y as usize * self.top_dims[0] as usize + x as usize] += u64::from(count);
                }
            }
            counts
        };
        let add = |mut sum: Vec<u64>, counts: Vec<u64>| {
            sum.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            sum
        };
        casting.par_iter().fold(none, count).reduce(none, add)
    }

    /// Returns the texels of a root block that are inside the grid.
    pub(crate) fn rect(&self, root_block: usize) -> TexelRect {
        let side = 1 << self.root_level;
        let (tx, ty) = (root_block as u32 % self.top_dims[0], root_block as u32 / self.top_dims[0]);
        let (x, y) = (tx * side, ty * side);
        TexelRect { x, y, width: side.min(self.grid.size[0] - x), height: side.min(self.grid.size[1] - y) }
    }
}
