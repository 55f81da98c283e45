//! Surfaces with holes over a leaf: which sample points of its texels they cover, where that still matters.
//!
//! Nothing behind a depth at which a texel is known to be half covered can be its first surface. Surfaces are visited
//! about in the order of their depths, so of many layers of leaves only the first few are sampled.

use super::texels::{Texels, rows_of};
use super::{Leaf, Setting, TEXELS};
use crate::columns::BLOCK_SIDE;
use crate::columns::masked::{self, MaskedHit, PLACES_REACH, TriangleMask};
use crate::texel_mask::{texels_of, texels_where};
use crate::triangles::project::{FixedDepth, SEAM_MARGIN, depths_within};

/// What is known of the masked surfaces of a leaf's columns.
pub(super) struct Masked {
    /// The sample points covered so far, and the depth of the deepest surface that covers any.
    covered: [u16; TEXELS],
    deepest: [FixedDepth; TEXELS],
    /// A depth at which the texel is half covered.
    pub(super) enough: Texels<FixedDepth>,
}

impl Masked {
    pub(super) fn none() -> Self {
        Self {
            covered: [0; TEXELS],
            deepest: [FixedDepth::MIN; TEXELS],
            enough: [[FixedDepth::MAX; BLOCK_SIDE]; BLOCK_SIDE],
        }
    }

    #[inline(always)]
    fn add(&mut self, texel: usize, depth: FixedDepth, places: u16) {
        let enough = &mut self.enough.as_flattened_mut()[texel];
        if places == u16::MAX {
            *enough = depth.min(*enough);
            return;
        }
        self.covered[texel] |= places;
        self.deepest[texel] = depth.max(self.deepest[texel]);
        if masked::is_enough(self.covered[texel]) {
            *enough = self.deepest[texel].min(*enough);
        }
    }
}

impl Leaf<'_> {
    /// Returns the texels whose first surface may be at this depth or deeper.
    #[inline(always)]
    pub(super) fn may_begin_from(&self, depth: FixedDepth) -> u64 {
        let (first, enough) = (self.first.depth.as_flattened(), self.masked.enough.as_flattened());
        texels_where(|t| (first[t] >= depth) & (enough[t] >= depth))
    }

    /// Samples the surface with this number, which has holes, at the `wanted` ones of the texels that it covers.
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
        let (first, enough) = (self.first.depth.as_flattened(), self.masked.enough.as_flattened());
        let depths = depths.as_flattened();
        let covered = covered & texels_where(|t| (depths[t] <= first[t]) & (depths[t] <= enough[t]));
        if covered == 0 {
            return;
        }
        let make = || TriangleMask::new(scene, grid, surface).map(Box::new);
        let mask = masks.get(number as usize).and_then(|mask| mask.get_or_init(make).as_deref());
        let Some(mask) = mask else { return };
        let info = rules.surface_info(shape.slope, surface.solid);
        let Some(table) = mask.table(opacity) else {
            for texel in texels_of(covered) {
                let center = [self.centers[0][texel % BLOCK_SIDE], self.centers[1][texel / BLOCK_SIDE]];
                self.add_hit(texel, depths[texel], info, mask.coverage(scene, center));
            }
            return;
        };
        let (center, half) = self.rectangle_around(covered);
        match mask.uniform_within(table, center, half.map(|h| h + PLACES_REACH)) {
            Some(false) => {}
            Some(true) => {
                for texel in texels_of(covered) {
                    self.add_hit(texel, depths[texel], info, u16::MAX);
                }
            }
            None => {
                let window = mask.texel_window(table);
                for row in 0..BLOCK_SIDE {
                    let wanted = (covered >> (BLOCK_SIDE * row) & 0xff) as u16;
                    if wanted == 0 {
                        continue;
                    }
                    let places =
                        mask.row_coverage(table, &window, wanted, &self.centers[0], self.centers[1][row]);
                    for column in texels_of(u64::from(wanted)) {
                        let texel = row * BLOCK_SIDE + column;
                        self.add_hit(texel, depths[texel], info, places[column]);
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn add_hit(&mut self, texel: usize, depth: FixedDepth, info: u32, places: u16) {
        if places != 0 {
            self.masked.add(texel, depth, places);
            self.buffers.masked.push(MaskedHit::new(texel, depth, info, places));
        }
    }

    /// Returns the middle of these texels' centres, and how far they reach from it.
    #[inline(always)]
    fn rectangle_around(&self, texels: u64) -> ([f64; 2], [f64; 2]) {
        let columns = columns_of(texels);
        let ends = [
            [columns.trailing_zeros(), 7 - columns.leading_zeros()],
            [texels.trailing_zeros() / 8, 7 - texels.leading_zeros() / 8],
        ];
        let along = |axis: usize| ends[axis].map(|end| self.centers[axis][end as usize]);
        let [[left, right], [top, bottom]] = [along(0), along(1)];
        ([0.5 * (left + right), 0.5 * (top + bottom)], [0.5 * (right - left), 0.5 * (bottom - top)])
    }

    /// Adds masked surfaces where they cover enough of a texel and are nearest.
    pub(super) fn add_masked(&mut self) {
        masked::add_first_surfaces(&mut self.buffers.masked, |texel, surface| {
            if surface < self.first.get(texel) {
                self.first.set(texel, surface);
            }
        });
    }
}

/// Returns the columns in which there are texels.
#[inline(always)]
fn columns_of(texels: u64) -> u8 {
    let halves = texels | texels >> 32;
    let quarters = halves | halves >> 16;
    (quarters | quarters >> 8) as u8
}
