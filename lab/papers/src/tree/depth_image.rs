//! The light's depth image over the cube of a tree, which voxel centres are tested against. Source: the
//! paper's §2.2. Closed regions follow §3 of the specification: intervals of positive winding, from the
//! geometry itself.
//!
//! It exists only during the bake. Texels are stored in tiles of 256 × 256, tile after tile, each tile row by
//! row. Depths are in 1/256 texel along the light.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use crate::tree::settings::CaptureBias;
use adumbra::Bias;
use adumbra::grid::LightGrid;
use adumbra_bake::structure::layers::{
    CaptureBuffers, FixedDepth, LayerCapture, LayerOptions, crossing, working_bytes,
};
use adumbra_scene::Scene;

const TILE_LOG2: u32 = 8;
/// Texels along the side of a tile.
pub(crate) const TILE_SIDE: u32 = 1 << TILE_LOG2;
const TILE_TEXELS: usize = 1 << (2 * TILE_LOG2);

/// Fractional bits of positions in an image, in texels.
pub(crate) const FRACTION: u32 = 32;
/// The depth of a texel without a surface.
pub(crate) const NO_SURFACE: FixedDepth = FixedDepth::MAX;

/// First depth, and the intervals inside solids, of every texel.
pub(crate) struct DepthImage {
    /// The texels of the image are its columns; z runs along the light.
    pub(crate) grid: LightGrid,
    tiles_x: usize,
    /// Upper bound of the distance that the capture bias moved any depth.
    pub(crate) largest_bias: FixedDepth,
    /// Depth of the first surface plus the capture bias.
    depths: Vec<FixedDepth>,
    /// By tile; `None` if the tile contains no solid.
    insides: Vec<Option<Insides>>,
}

/// Depth intervals inside solids, by texel of one tile.
struct Insides {
    /// The intervals of texel i are `intervals[starts[i]..starts[i + 1]]`.
    starts: Vec<u32>,
    intervals: Vec<[FixedDepth; 2]>,
}

/// Bytes that a depth image of `grid` needs while it is rendered, except for the intervals inside solids: its
/// depths, the start of each column's intervals, and the lists of one tile per thread.
pub(crate) fn image_bytes(grid: &LightGrid, closed_regions: bool) -> u64 {
    let tiles = tiles_of(grid);
    let texels = u64::from(tiles[0]) * u64::from(tiles[1]) * TILE_TEXELS as u64;
    let lists = working_bytes(TILE_TEXELS as u64) * rayon::current_num_threads() as u64;
    texels * if closed_regions { 8 } else { 4 } + lists
}

fn tiles_of(grid: &LightGrid) -> [u32; 2] {
    [grid.size[0].div_ceil(TILE_SIDE), grid.size[1].div_ceil(TILE_SIDE)]
}

/// The options that determine a depth image, besides the scene and the grid.
#[derive(Clone, Copy)]
pub(crate) struct DepthImageOptions {
    pub(crate) closed_regions: bool,
    pub(crate) ignore_alpha: bool,
    pub(crate) capture_bias: CaptureBias,
}

impl DepthImage {
    /// Renders `scene` from the light into the columns of `grid`, and counts the triangles that cast shadows.
    /// Runs on rayon's threads; the result does not depend on their number. Once `cancel` is set, the
    /// remaining tiles stay empty.
    ///
    /// # Errors
    /// Returns a lower bound of the bytes needed if the image and its renderer take more than `room_bytes`.
    pub(crate) fn capture(
        scene: &Scene,
        grid: &LightGrid,
        options: DepthImageOptions,
        room_bytes: Option<u64>,
        cancel: &AtomicBool,
    ) -> Result<(Self, u64), u64> {
        let tiles = tiles_of(grid);
        let bias = options.capture_bias;
        let layer_options = LayerOptions {
            closed_regions: options.closed_regions,
            ignore_alpha: options.ignore_alpha,
            bias: Bias {
                constant_texels: bias.constant_texels,
                slope_texels: bias.slope_texels,
                normal_offset_texels: 0.0,
            },
        };
        let layers = LayerCapture::new(scene, grid, layer_options, TILE_SIDE);
        let held_bytes = AtomicU64::new(layers.memory_bytes() + image_bytes(grid, false));
        let is_full = |held_bytes: u64| room_bytes.is_some_and(|room| held_bytes > room);
        let mut depths = vec![NO_SURFACE; (tiles[0] * tiles[1]) as usize * TILE_TEXELS];
        let insides = depths
            .par_chunks_mut(TILE_TEXELS)
            .enumerate()
            .map_init(<(CaptureBuffers, Vec<_>)>::default, |(buffers, found), (tile, depths)| {
                if cancel.load(Ordering::Relaxed) {
                    return None;
                }
                found.clear();
                layers.tile(tile, buffers, |[column, row], first, crossings| {
                    let texel = row << TILE_LOG2 | column;
                    if let Some(first) = first {
                        depths[texel as usize] = first;
                    }
                    let crossings = crossings.iter().copied().map(crossing);
                    for_each_inside(crossings, |from, to| found.push((texel, [from, to])));
                });
                let insides = Insides::of(found);
                let bytes = insides.as_ref().map_or(0, Insides::memory_bytes);
                // Also count intervals that do not fit, so that the error states the bytes of the whole
                // image.
                let held = held_bytes.fetch_add(bytes, Ordering::Relaxed) + bytes;
                insides.filter(|_| !is_full(held))
            })
            .collect();
        let held_bytes = held_bytes.into_inner();
        if is_full(held_bytes) {
            return Err(held_bytes);
        }
        let (instanced_triangles, largest_bias) = (layers.instanced_triangles(), layers.largest_bias());
        let image = Self { grid: *grid, tiles_x: tiles[0] as usize, largest_bias, depths, insides };
        Ok((image, instanced_triangles))
    }

    /// Number of texels along x and y.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.grid.size[0], self.grid.size[1]]
    }

    /// Returns the first depth of a texel; `u` and `v` must be below [`DepthImage::size`].
    pub(crate) fn depth(&self, u: u32, v: u32) -> FixedDepth {
        let (tile, texel) = self.place(u, v);
        self.depths[tile * TILE_TEXELS + texel]
    }

    /// Returns the intervals inside solids of a texel, nearest first.
    pub(crate) fn insides(&self, u: u32, v: u32) -> &[[FixedDepth; 2]] {
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
    pub(crate) fn memory_bytes(&self) -> u64 {
        let insides: u64 = self.insides.iter().flatten().map(Insides::memory_bytes).sum();
        (self.depths.capacity() * size_of::<FixedDepth>()) as u64 + insides
    }
}

impl Insides {
    fn memory_bytes(&self) -> u64 {
        (size_of_val(&*self.starts) + size_of_val(&*self.intervals)) as u64
    }

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

/// Calls `visit(from, to)` for every interval of positive winding in sorted crossings, each of which is a
/// depth and whether a solid is left there; `to` is where the winding is back at 0. Visits nothing if the
/// count becomes negative; then the column is open. A solid that is entered but never left has no interval.
fn for_each_inside(
    crossings: impl Iterator<Item = (FixedDepth, bool)> + Clone,
    mut visit: impl FnMut(FixedDepth, FixedDepth),
) {
    let step = |leaves: bool| if leaves { -1 } else { 1 };
    let mut winding = 0;
    for (_, leaves) in crossings.clone() {
        winding += step(leaves);
        if winding < 0 {
            return;
        }
    }
    let (mut winding, mut from) = (0, 0);
    for (depth, leaves) in crossings {
        if winding == 0 {
            from = depth;
        }
        winding += step(leaves);
        if winding == 0 && depth > from {
            visit(from, depth);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the intervals of crossings that are given as (depth, is left).
    fn insides(crossings: &[(FixedDepth, bool)]) -> Vec<(FixedDepth, FixedDepth)> {
        let mut sorted = crossings.to_vec();
        sorted.sort_unstable();
        let mut found = Vec::new();
        for_each_inside(sorted.into_iter(), |from, to| found.push((from, to)));
        found
    }

    #[test]
    fn columns_are_inside_solids_from_entry_to_exit() {
        let (enters, leaves) = (|d| (d, false), |d| (d, true));
        assert_eq!(insides(&[]), []);
        assert_eq!(insides(&[enters(-5), leaves(9)]), [(-5, 9)]);
        // Nested, and one behind the other.
        let nested = [enters(10), enters(20), leaves(30), leaves(40), enters(50), leaves(60)];
        assert_eq!(insides(&nested), [(10, 40), (50, 60)]);
        // Abutting: at equal depth entering sorts before leaving, so there is no gap.
        assert_eq!(insides(&[enters(1), leaves(5), enters(5), leaves(8)]), [(1, 8)]);
        // Zero thickness; never left; left before it is entered.
        assert_eq!(insides(&[enters(3), leaves(3)]), []);
        assert_eq!(insides(&[enters(1), leaves(2), enters(7)]), [(1, 2)]);
        assert_eq!(insides(&[leaves(0), enters(1), leaves(2)]), []);
    }
}
