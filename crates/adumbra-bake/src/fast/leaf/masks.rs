//! Surfaces with holes over a leaf: at which of its texels' centres they are opaque, where that still
//! matters.
//!
//! Surfaces are visited about in the order of their depths, so of many layers of leaves only the first few
//! are sampled.

use super::texels::{LANES, rows_of};
use super::{Leaf, Setting};
use crate::columns::BLOCK_SIDE;
use crate::columns::masked::TriangleMask;
use crate::texel_mask::{texels_of, texels_where};
use crate::triangles::depth::{FixedDepth, depths_within};
use crate::triangles::project::SEAM_MARGIN;

impl Leaf<'_> {
    /// Returns the texels whose first surface may be at this depth or deeper.
    #[inline(always)]
    pub(super) fn may_begin_from(&self, depth: FixedDepth) -> u64 {
        let first = self.first.depth.as_flattened();
        texels_where(|t| first[t] >= depth)
    }

    /// Samples the surface with this number, which has holes, at those of the `wanted` texels that it covers.
    #[inline(always)]
    pub(super) fn sample_masked(&mut self, number: u32, wanted: u64) {
        let Setting { scene, grid, rules, opacity, surfaces, masks, .. } = self.setting;
        let surface = &surfaces[number as usize].surface;
        let shape = &surface.shape;
        let Some(plane) = shape.plane.filter(|_| wanted != 0) else { return };
        let margin = if surface.solid { 0 } else { SEAM_MARGIN };
        let covered = wanted & shape.coverage(self.block.x, self.block.y, [margin])[0];
        if covered == 0 {
            return;
        }
        let range = shape.depth_range();
        let mut depths = [[FixedDepth::MAX; BLOCK_SIDE]; BLOCK_SIDE];
        for (row, _) in rows_of(covered) {
            depths[row] = depths_within(range, plane.along(&self.centers[0], self.centers[1][row]));
        }
        let (first, found) = (self.first.depth.as_flattened(), depths.as_flattened());
        let covered = covered & texels_where(|t| found[t] <= first[t]);
        if covered == 0 {
            return;
        }
        let make = || TriangleMask::new(scene, grid, surface).map(Box::new);
        let mask = masks.get(number as usize).and_then(|mask| mask.get_or_init(make).as_deref());
        let Some(mask) = mask else { return };
        let info = rules.surface_info(shape.slope, surface.solid);
        let table = mask.table(opacity);
        for (row, wanted) in covered.to_le_bytes().into_iter().enumerate().filter(|(_, wanted)| *wanted != 0)
        {
            let (columns, y) = (&self.centers[0], self.centers[1][row]);
            let opaque = match table {
                Some(table) => wanted & mask.opaque_along(table, columns, y),
                None => texels_of(u64::from(wanted))
                    .filter(|&column| mask.is_opaque(scene, [columns[column], y]))
                    .fold(0, |opaque, column| opaque | 1 << column),
            };
            self.first.add_row(row, &LANES[usize::from(opaque)], &depths[row], info, number);
        }
    }
}
