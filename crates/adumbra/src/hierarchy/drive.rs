//! Any sink from a scene's columns, tile by tile, every texel drawn: what the tests judge a sink by.

use rayon::prelude::*;

use super::from_columns::block_of;
use crate::bake::Options;
use crate::bake::capture::{CaptureBuffers, TileRect, capture};
use crate::bake::casters::{CasterOptions, Casters};
use crate::bake::columns::{ColumnRules, Columns, FREE_TO_END};
use crate::bake::sink::BlockSink;
use crate::light::{LightExtent, LightGrid};
use crate::scene::Scene;

/// A bake's grid and columns, ready to be drawn.
pub(super) struct Drive<'s> {
    pub(super) grid: LightGrid,
    pub(super) root_level: u32,
    casters: Casters<'s>,
    rules: ColumnRules,
}

impl<'s> Drive<'s> {
    /// As the plain bake lays it out.
    pub(super) fn new(scene: &'s Scene, options: &Options) -> Self {
        let mut extent = LightExtent::empty(&options.sun);
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh as usize];
            for &v in mesh.triangles.iter().flatten() {
                extent.add(instance.to_world(mesh.positions[v as usize]));
            }
        }
        let (resolution, voxel_size) = options.size.resolve(extent.longest_side()).expect("a good size");
        let grid = LightGrid::covering(options.sun, &extent, voxel_size);
        let root_level = resolution.ilog2().saturating_sub(5).clamp(5, 10);
        let tiles = [grid.size[0], grid.size[1]].map(|n| n.div_ceil(1 << root_level));
        let rules = ColumnRules {
            bias: options.bias,
            thickness_voxels: options.thickness_world / voxel_size,
            assume_ground: options.assume_ground,
            receivers: options.receivers,
            depth_voxels: grid.size[2],
        };
        let caster_options =
            CasterOptions { closed_regions: options.closed_regions, ignore_alpha: options.ignore_alpha };
        let reach = rules.reach_texels() + 1.0;
        let casters = Casters::new(scene, caster_options, &grid, 1 << root_level, tiles, reach);
        Self { grid, root_level, casters, rules }
    }

    fn tiles(&self) -> [u32; 2] {
        [self.grid.size[0], self.grid.size[1]].map(|n| n.div_ceil(1 << self.root_level))
    }

    /// Every tile's block, x fastest.
    pub(super) fn blocks<S: BlockSink>(&self, sink: &S) -> Vec<S::Block> {
        let tiles = self.tiles();
        (0..tiles[0] * tiles[1])
            .into_par_iter()
            .map_init(
                || (CaptureBuffers::default(), Columns::default()),
                |(buffers, columns), tile| {
                    self.columns(tile, buffers, columns);
                    block_of(sink, &|i, j| of_tile(columns, i, j), self.root_level, [0; 2])
                },
            )
            .collect()
    }

    /// Columns of one tile.
    pub(super) fn columns(&self, tile: u32, buffers: &mut CaptureBuffers, columns: &mut Columns) {
        let side = 1 << self.root_level;
        let [x, y] = [tile % self.tiles()[0], tile / self.tiles()[0]].map(|t| t * side);
        let size = self.grid.size;
        let rect = TileRect { x, y, width: side.min(size[0] - x), height: side.min(size[1] - y) };
        capture(&self.casters, tile as usize, &self.grid, &self.rules, rect, buffers, columns);
    }
}

/// `[e, x]` of a tile's column; free beside the tile.
pub(super) fn of_tile(columns: &Columns, i: u32, j: u32) -> [u32; 2] {
    if i >= columns.width || j >= columns.height {
        return [0, FREE_TO_END];
    }
    let at = (j * columns.width + i) as usize;
    [columns.e[at], columns.x[at]]
}
