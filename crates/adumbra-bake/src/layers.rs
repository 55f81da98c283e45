//! First surfaces, and the crossings of solids, for every texel of a light-aligned grid, tile by tile: the
//! input for structures that voxelize depth themselves.

use adumbra::{Bias, LightGrid, MAX_SLOPE, Receivers};
use adumbra_scene::Scene;

use crate::columns::capture::{CaptureBuffers, TexelRect, capture_layers};
use crate::columns::rules::{ColumnRules, NormalOffset};
use crate::triangles::casters::{self, CasterOptions, Casters, SceneClusters};
use crate::triangles::depth::FixedDepth;
use crate::triangles::surface::BinSurfaces;

/// How a scene is interpreted.
#[derive(Clone, Copy, Debug)]
pub struct LayerOptions {
    /// Whether the crossings of closed components are found.
    pub closed_regions: bool,
    /// Whether masked materials count as opaque.
    pub ignore_alpha: bool,
    /// Bias added to the depth of first surfaces. Its offset along the normal is ignored.
    pub bias: Bias,
}

/// A scene, sorted into square tiles of a grid.
pub struct LayerCapture<'s> {
    casters: Casters<'s>,
    rules: ColumnRules,
    grid: LightGrid,
    tile_side: u32,
}

impl<'s> LayerCapture<'s> {
    /// Sorts `scene` into tiles of `tile_side` texels a side. Cost: one visit per cluster of triangles.
    pub fn new(scene: &'s Scene, grid: &LightGrid, options: LayerOptions, tile_side: u32) -> Self {
        let caster_options = caster_options(options.closed_regions, options.ignore_alpha);
        let tiles = [grid.size[0].div_ceil(tile_side), grid.size[1].div_ceil(tile_side)];
        let casters =
            Casters::new(scene, SceneClusters::new(scene, caster_options), grid, tile_side, tiles, 1.0);
        let rules = ColumnRules {
            bias: options.bias,
            thickness: 0,
            level_lift: None,
            receivers: Receivers::All,
            depth_voxels: 0,
            normal_offset: NormalOffset::new(&options.bias, grid),
        };
        Self { casters, rules, grid: *grid, tile_side }
    }

    /// Bytes held besides the scene.
    pub fn memory_bytes(&self) -> u64 {
        self.casters.memory_bytes()
    }

    /// Number of triangles that cast shadows, counted once per instance.
    pub fn instanced_triangles(&self) -> u64 {
        self.casters.instanced_triangles()
    }

    /// Upper bound on how far the bias moves any depth, in 1/256 voxel.
    pub fn largest_bias(&self) -> FixedDepth {
        self.rules.surface_info(MAX_SLOPE, true) as FixedDepth + 1
    }

    /// Calls `visit([column, row], first, crossings)` once for each texel of a tile, in no particular order:
    /// with the depth of its first surface, bias included, or `None` if it has none, and with each
    /// [`crossing`](crate::columns::crossings::crossing) of a solid, sorted by depth, then entry before exit.
    /// Columns and rows are counted from the tile's corner; tiles are numbered row by row.
    pub fn tile(
        &self,
        tile: usize,
        buffers: &mut CaptureBuffers,
        mut visit: impl FnMut([u32; 2], Option<FixedDepth>, &[u32]),
    ) {
        let tiles_x = self.grid.size[0].div_ceil(self.tile_side);
        let [x, y] = [tile as u32 % tiles_x, tile as u32 / tiles_x].map(|t| t * self.tile_side);
        let width = self.tile_side.min(self.grid.size[0] - x);
        let height = self.tile_side.min(self.grid.size[1] - y);
        let rect = TexelRect { x, y, width, height };
        let surfaces = BinSurfaces { casters: &self.casters, bin: tile, grid: &self.grid };
        capture_layers(&surfaces, &self.rules, rect, buffers, |texel, first, crossings| {
            let first = (!first.is_none()).then(|| first.depth().saturating_add(first.bias()));
            visit([texel as u32 % width, texel as u32 / width], first, crossings);
        });
    }
}

fn caster_options(closed_regions: bool, ignore_alpha: bool) -> CasterOptions {
    CasterOptions { closed_regions, ignore_alpha, outlines: false, limit_bytes: None }
}

/// Bytes that [`LayerCapture::new`] holds at most besides the scene, with these options.
pub fn sorting_bytes(scene: &Scene, closed_regions: bool, ignore_alpha: bool) -> u64 {
    casters::sorting_bytes(scene, caster_options(closed_regions, ignore_alpha))
}
