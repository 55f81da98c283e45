//! The light's depth image over a tree's cube: what voxel centres are tested against. Source: the paper's §2.2; closed
//! regions after the specification's §3: intervals of positive winding, from the geometry itself.
//!
//! It exists only during the bake. Texels lie in tiles of 256 × 256, tile after tile, each row by row; depths are in
//! 1/256 texel along the light.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::settings::CaptureBias;
use crate::bake::capture::{CaptureBuffers, TileRect, capture_layers, working_bytes};
use crate::bake::casters::{CasterOptions, Casters};
use crate::bake::columns::{ColumnRules, for_each_inside};
use crate::bake::project::FixedDepth;
use crate::bake::surface::TileSurfaces;
use crate::light::LightGrid;
use crate::scene::Scene;
use crate::settings::{Bias, MAX_SLOPE, Receivers};

const TILE_LOG2: u32 = 8;
/// Texels along a tile's side.
pub(super) const TILE_SIDE: u32 = 1 << TILE_LOG2;
const TILE_TEXELS: usize = 1 << (2 * TILE_LOG2);

/// Fractional bits of positions in an image, in texels.
pub(super) const FRACTION: u32 = 32;
/// The depth of no surface.
pub(super) const NO_SURFACE: FixedDepth = FixedDepth::MAX;

/// First depths, and the insides of solids, of every texel.
pub(super) struct DepthImage {
    /// Its texels are the columns; z counts along the light.
    pub(super) grid: LightGrid,
    tiles_x: usize,
    /// No depth was moved farther than this by the capture bias.
    pub(super) largest_bias: FixedDepth,
    /// First surface plus capture bias.
    depths: Vec<FixedDepth>,
    /// By tile; none where no solid is in it.
    insides: Vec<Option<Insides>>,
}

/// Intervals of depth inside solids, by texel of one tile.
struct Insides {
    /// Intervals of texel i: `intervals[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    intervals: Vec<[FixedDepth; 2]>,
}

/// What a depth image of `grid` takes while it is drawn, but for the intervals inside solids: its depths, where each
/// column's intervals begin, and a tile's lists for every thread.
pub(super) fn image_bytes(grid: &LightGrid, closed_regions: bool) -> u64 {
    let tiles = tiles_of(grid);
    let texels = u64::from(tiles[0]) * u64::from(tiles[1]) * TILE_TEXELS as u64;
    let lists = working_bytes(TILE_TEXELS as u64) * rayon::current_num_threads() as u64;
    texels * if closed_regions { 8 } else { 4 } + lists
}

fn tiles_of(grid: &LightGrid) -> [u32; 2] {
    [grid.size[0].div_ceil(TILE_SIDE), grid.size[1].div_ceil(TILE_SIDE)]
}

/// What decides a depth image besides the scene and the grid.
#[derive(Clone, Copy)]
pub(super) struct DepthImageOptions {
    pub(super) closed_regions: bool,
    pub(super) ignore_alpha: bool,
    pub(super) capture_bias: CaptureBias,
}

impl DepthImage {
    /// Draws `scene` from the light into the columns of `grid`, and counts the triangles that cast. On rayon's threads; the
    /// same for any number of them. Once `cancel` is set what is left stays empty.
    pub(super) fn capture(
        scene: &Scene,
        grid: &LightGrid,
        options: DepthImageOptions,
        cancel: &AtomicBool,
    ) -> (Self, u64) {
        let tiles = tiles_of(grid);
        let caster_options = CasterOptions {
            closed_regions: options.closed_regions,
            ignore_alpha: options.ignore_alpha,
            outlines: false,
        };
        let casters = Casters::new(scene, caster_options, grid, TILE_SIDE, tiles, 1.0);
        let bias = options.capture_bias;
        let rules = ColumnRules {
            bias: Bias {
                constant_texels: bias.constant_texels,
                slope_texels: bias.slope_texels,
                normal_offset_texels: 0.0,
            },
            thickness_voxels: 0.0,
            assume_ground: false,
            receivers: Receivers::All,
            depth_voxels: 0,
        };
        let mut depths = vec![NO_SURFACE; (tiles[0] * tiles[1]) as usize * TILE_TEXELS];
        let insides = depths
            .par_chunks_mut(TILE_TEXELS)
            .enumerate()
            .map_init(CaptureBuffers::default, |buffers, (tile, depths)| {
                if cancel.load(Ordering::Relaxed) {
                    return None;
                }
                let corner = [tile as u32 % tiles[0], tile as u32 / tiles[0]].map(|t| t * TILE_SIDE);
                let rect = TileRect {
                    x: corner[0],
                    y: corner[1],
                    width: TILE_SIDE.min(grid.size[0] - corner[0]),
                    height: TILE_SIDE.min(grid.size[1] - corner[1]),
                };
                let mut found: Vec<(u32, [FixedDepth; 2])> = Vec::new();
                let surfaces = TileSurfaces { casters: &casters, tile, grid };
                capture_layers(&surfaces, &rules, rect, buffers, |texel, first, crossings| {
                    let (row, column) = (texel as u32 / rect.width, texel as u32 % rect.width);
                    let texel = row << TILE_LOG2 | column;
                    if !first.is_none() {
                        depths[texel as usize] = first.depth().saturating_add(first.bias());
                    }
                    for_each_inside(crossings, |from, to| found.push((texel, [from, to])));
                });
                Insides::of(&mut found)
            })
            .collect();
        let instanced_triangles = casters.instanced_triangles();
        let largest_bias = rules.surface_info(MAX_SLOPE, true) as FixedDepth + 1;
        let image = Self { grid: *grid, tiles_x: tiles[0] as usize, largest_bias, depths, insides };
        (image, instanced_triangles)
    }

    /// Texels along x and y.
    pub(super) fn size(&self) -> [u32; 2] {
        [self.grid.size[0], self.grid.size[1]]
    }

    /// First depth of a texel; `u`, `v` below [`DepthImage::size`].
    pub(super) fn depth(&self, u: u32, v: u32) -> FixedDepth {
        let (tile, texel) = self.place(u, v);
        self.depths[tile * TILE_TEXELS + texel]
    }

    /// Intervals inside solids of a texel, nearest first.
    pub(super) fn insides(&self, u: u32, v: u32) -> &[[FixedDepth; 2]] {
        let (tile, texel) = self.place(u, v);
        match &self.insides[tile] {
            Some(insides) => {
                &insides.intervals[insides.starts[texel] as usize..insides.starts[texel + 1] as usize]
            }
            None => &[],
        }
    }

    fn place(&self, u: u32, v: u32) -> (usize, usize) {
        let tile = (v >> TILE_LOG2) as usize * self.tiles_x + (u >> TILE_LOG2) as usize;
        (tile, ((v & (TILE_SIDE - 1)) << TILE_LOG2 | u & (TILE_SIDE - 1)) as usize)
    }

    /// Bytes held.
    pub(super) fn memory_bytes(&self) -> u64 {
        let insides = self.insides.iter().flatten();
        let intervals: usize = insides.map(|i| i.starts.capacity() * 4 + i.intervals.capacity() * 8).sum();
        (self.depths.capacity() * size_of::<FixedDepth>() + intervals) as u64
    }
}

impl Insides {
    fn of(found: &mut [(u32, [FixedDepth; 2])]) -> Option<Self> {
        if found.is_empty() {
            return None;
        }
        found.sort_unstable();
        let mut starts = vec![0; TILE_TEXELS + 1];
        for (texel, _) in found.iter() {
            starts[*texel as usize + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        Some(Self { starts, intervals: found.iter().map(|(_, interval)| *interval).collect() })
    }
}
