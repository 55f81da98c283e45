//! Chooses the bundles that views need: those where the next coarser level would be too coarse, the most
//! urgent first.

use crate::grid::LightGrid;
use crate::grid::vec3::dot;
use crate::layout::depths::page::{BUNDLE_SIDE, PAGE_LEVEL};
use crate::stream::View;
use crate::stream::view::GridBox;

/// Texels around a bundle that filters and biases may reach, and voxels before its nearest depth.
const MARGIN: f64 = 16.0;
/// Bundles out of sight count as if they were this many times farther away.
const OUT_OF_SIGHT: f64 = 4.0;
/// Texels along a side of a bundle.
const BUNDLE_TEXELS: f64 = (BUNDLE_SIDE << PAGE_LEVEL) as f64;

/// A level whose bundles may be needed.
pub(super) struct Candidates<'a> {
    pub(super) grid: &'a LightGrid,
    /// Texel of the next coarser level, world units.
    pub(super) coarser_texel_world: f64,
    /// Bundles along x and y.
    pub(super) dims: [u32; 2],
}

impl Candidates<'_> {
    /// Calls `found` with each bundle that a view needs, by place, and its need. `nearest` is the nearest
    /// depth of a bundle, or `None` if it has no bytes.
    pub(super) fn each(
        &self,
        view: &View,
        detail_pixels: f64,
        nearest: impl Fn([u32; 2]) -> Option<u32>,
        mut found: impl FnMut([u32; 2], f64),
    ) {
        let fine_pixel = self.coarser_texel_world / detail_pixels;
        let reach_world = view.distance_of(fine_pixel);
        if reach_world <= 0.0 {
            return;
        }
        let camera = self.grid.to_grid(view.position_world);
        let range = |a: usize| {
            let axis = self.grid.axes[a];
            let reach = reach_world * dot(axis, axis).sqrt() / self.grid.voxel_size + MARGIN;
            let bundle = |texel: f64| (texel / BUNDLE_TEXELS).floor().clamp(-1.0, f64::from(self.dims[a]));
            let [low, high] = [bundle(camera[a] - reach), bundle(camera[a] + reach)];
            low.max(0.0) as u32..(high + 1.0).clamp(0.0, f64::from(self.dims[a])) as u32
        };
        for y in range(1) {
            for x in range(0) {
                let Some(nearest) = nearest([x, y]) else { continue };
                let grid_box = self.grid_box([x, y], nearest);
                let distance = grid_box.distance(view.position_world);
                let pixel = view.pixel_at(distance);
                if pixel >= fine_pixel {
                    continue;
                }
                let seen = if view.may_see(&grid_box) { 1.0 } else { OUT_OF_SIGHT };
                let need = fine_pixel / (pixel * seen);
                if need > 1.0 {
                    found([x, y], need);
                }
            }
        }
    }

    fn grid_box(&self, bundle: [u32; 2], nearest: u32) -> GridBox<'_> {
        let size = self.grid.size.map(f64::from);
        let low = bundle.map(|c| f64::from(c) * BUNDLE_TEXELS);
        let from = |a: usize| low[a] - MARGIN;
        let to = |a: usize| (low[a] + BUNDLE_TEXELS).min(size[a]) + MARGIN;
        let depth = (f64::from(nearest) - MARGIN).clamp(0.0, size[2]);
        GridBox::new(self.grid, [from(0), from(1), depth], [to(0), to(1), size[2]])
    }
}
