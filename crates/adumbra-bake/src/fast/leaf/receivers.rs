//! The constraints on a leaf's columns from receivers behind its first surfaces, and from filters around
//! receivers.

use super::texels::{Texels, rows_of};
use super::{Leaf, Near, NearSurfaces};
use crate::columns::rules::{CONTACT_RINGS, ColumnRules, FREE_TO_END, FirstSurface, ReceiverKind};
use crate::columns::{BLOCK_SIDE, BlockColumns};
use crate::fast::block::BlockSurface;
use crate::texel_mask::{texels_of, texels_where};
use crate::triangles::depth::{FixedDepth, SUBTEXEL};

/// A receiver that samples a column at least this far behind its exit does not change the column: rounding of
/// the exit, 1/256 voxel.
const BEHIND_EXIT: FixedDepth = SUBTEXEL as FixedDepth / 2 + 1;
/// More than the rounding of a plane's depth, voxels.
const ROUNDING: f64 = 1.0 / SUBTEXEL as f64;

impl Leaf<'_> {
    /// Finds, for each column with a first surface, the nearest depth at which a receiver behind its base
    /// samples it. Some receiver behind all bases is sampled at `known_behind` or deeper.
    #[inline(always)]
    pub(super) fn ask_all(&mut self, order: &[Near], known_behind: FixedDepth) {
        let rules = *self.setting.rules;
        let asking = self.inside & self.first.met();
        for row in 0..BLOCK_SIDE {
            for c in 0..BLOCK_SIDE {
                let first = FirstSurface::new(self.first.depth[row][c], self.first.info[row][c]);
                let (base, deepest) = (self.base[row][c], self.deepest[row][c]);
                let exit = rules.exit(first, base);
                let is_free = rules.latest_switch(exit) == FREE_TO_END;
                let shadowed_from = if is_free { FixedDepth::MAX } else { exit.saturating_add(BEHIND_EXIT) };
                let farthest = shadowed_from.max(base.saturating_add(SUBTEXEL as FixedDepth));
                let next = if deepest > farthest { known_behind.min(deepest) } else { known_behind };
                let next = next.min(rules.below(first, base));
                // While no receiver behind is known, a ground is assumed and any receiver counts.
                let any_counts = next == FixedDepth::MAX;
                self.shadowed_from[row][c] = shadowed_from;
                self.next[row][c] = if first.is_none() { FixedDepth::MAX } else { next };
                self.matters_before[row][c] =
                    if any_counts { FixedDepth::MAX } else { shadowed_from.min(next) };
            }
        }
        let nearest = |depths: &Texels<FixedDepth>| {
            let mut nearest = FixedDepth::MAX;
            for (t, &depth) in depths.as_flattened().iter().enumerate() {
                nearest = nearest.min(if asking >> t & 1 == 1 { depth } else { FixedDepth::MAX });
            }
            nearest
        };
        let (base_low, first_low) = (nearest(&self.base), nearest(&self.first.depth));
        let half = self.setting.rules.footprint_half_texels(ReceiverKind::Footprint);
        // Snapping may have moved the corners.
        let reach = (half * SUBTEXEL as f64).ceil() as i64 + 2;
        let mut any_matters_before = self.any_matters_before(asking);
        for near in order {
            let Some(range) = &self.ranges[near.place as usize].sampled else { continue };
            if range.deepest <= base_low
                || range.lifted_high <= first_low
                || range.lifted_low >= any_matters_before
            {
                continue;
            }
            // The first surface is not behind itself.
            let surface = &self.setting.surfaces[near.surface as usize];
            let within_reach = surface.surface.shape.centers_within_box(self.block.x, self.block.y, reach);
            let (owner, before) = (self.first.owner.as_flattened(), self.matters_before.as_flattened());
            let base = self.base.as_flattened();
            let may_matter = texels_where(|t| {
                (owner[t] != near.surface) & (range.lifted_low < before[t]) & (range.deepest > base[t])
            });
            let wanted = asking & within_reach & may_matter;
            if wanted != 0 {
                self.ask(wanted, surface);
                any_matters_before = self.any_matters_before(asking);
            }
        }
    }

    /// Returns the largest of [`Self::matters_before`] over these texels.
    #[inline(always)]
    fn any_matters_before(&self, asking: u64) -> FixedDepth {
        let mut farthest = FixedDepth::MIN;
        for (texel, &depth) in self.matters_before.as_flattened().iter().enumerate() {
            farthest = farthest.max(if asking >> texel & 1 == 1 { depth } else { FixedDepth::MIN });
        }
        farthest
    }

    /// Bounds the columns where filters around surfaces near them read.
    #[inline(always)]
    pub(super) fn bound(&self, near: NearSurfaces<'_>, columns: &mut BlockColumns) {
        let rules = *self.setting.rules;
        let can_be_bounded = |columns: &BlockColumns| {
            self.inside & texels_where(|t| columns.x[t] > ColumnRules::contact_from(columns.e[t]))
        };
        let mut open = can_be_bounded(columns);
        let margins = rules.contact_margins();
        let (mut nearest_from, mut farthest_x) = (u32::MAX, 0);
        for (texel, (&e, &x)) in columns.e.iter().zip(&columns.x).enumerate() {
            let is_open = open >> texel & 1 == 1;
            nearest_from = nearest_from.min(if is_open { ColumnRules::contact_from(e) } else { u32::MAX });
            farthest_x = farthest_x.max(if is_open { x } else { 0 });
        }
        let half_side = (BLOCK_SIDE - 1) as f64 / 2.0;
        let [x, y] = [0, 1].map(|axis| self.centers[axis][0] + half_side);
        for &s in near.list.iter().chain(near.beside) {
            if open == 0 {
                return;
            }
            let surface = &self.setting.surfaces[s as usize];
            let Some(receiver) = surface.receiver else { continue };
            let (z, rise) = (receiver.plane.at(x, y), half_side * receiver.plane.gradient_sum());
            if rules.contact_at(&receiver, z + rise + ROUNDING) < nearest_from
                || rules.contact_at(&receiver, z - rise - ROUNDING) >= farthest_x
            {
                continue;
            }
            let shape = &surface.surface.shape;
            let near =
                open & shape.centers_within_box(self.block.x, self.block.y, margins[CONTACT_RINGS - 1]);
            let mut contacts = [[0; BLOCK_SIDE]; BLOCK_SIDE];
            for (row, _) in rows_of(near) {
                let z = receiver.plane.along(&self.centers[0], self.centers[1][row]);
                for (contact, z) in contacts[row].iter_mut().zip(z) {
                    *contact = rules.contact_at(&receiver, z);
                }
            }
            let contacts = contacts.as_flattened();
            let wanted = near
                & texels_where(|t| {
                    (contacts[t] >= ColumnRules::contact_from(columns.e[t])) & (contacts[t] < columns.x[t])
                });
            if wanted == 0 {
                continue;
            }
            let reached = shape.coverage(self.block.x, self.block.y, margins);
            for texel in texels_of(wanted & reached[CONTACT_RINGS - 1]) {
                let ring = reached.iter().filter(|mask| **mask >> texel & 1 == 0).count();
                columns.x[texel] =
                    ColumnRules::bounded([columns.e[texel], columns.x[texel]], ring, contacts[texel]);
            }
            open = can_be_bounded(columns);
        }
    }

    /// Evaluates `surface` as a receiver for the texels in `wanted`.
    #[inline(always)]
    fn ask(&mut self, wanted: u64, BlockSurface { surface, receiver, .. }: &BlockSurface) {
        let (block, rules) = (self.block, self.setting.rules);
        let Some(receiver) = receiver else { return };
        let half = rules.footprint_half_texels(ReceiverKind::Footprint);
        // The texels at which it is sampled behind the base, and nearer than the known receivers.
        let mut counts = [[false; BLOCK_SIDE]; BLOCK_SIDE];
        for (row, _) in rows_of(wanted) {
            let z = receiver.plane.along(&self.centers[0], self.centers[1][row]);
            for c in 0..BLOCK_SIDE {
                let sampled = receiver.sampled_at(ReceiverKind::Footprint, z[c]);
                counts[row][c] = (sampled.plane > self.base[row][c])
                    & (sampled.lifted > self.first.depth[row][c])
                    & (sampled.lifted < self.next[row][c]);
            }
        }
        let wanted = wanted & texels_where(|t| counts.as_flattened()[t]);
        for row in 0..BLOCK_SIDE {
            let wanted = wanted >> (row * BLOCK_SIDE) & 0xff;
            if wanted == 0 {
                continue;
            }
            let y = self.centers[1][row];
            let Some([low, high]) = surface.shape.x_range_in_band(y, half) else { continue };
            for column in texels_of(wanted) {
                let x = self.centers[0][column];
                if x < low - half || x > high + half {
                    continue;
                }
                let texel = row * BLOCK_SIDE + column;
                let at = [block.x + column as u32, block.y + row as u32].map(i64::from);
                let (base, first) = (self.base[row][column], self.first.get(texel));
                let triangle = (&surface.shape, receiver);
                let next = rules.receiver_behind(ReceiverKind::Footprint, triangle, at, base, first);
                if next < self.next[row][column] {
                    self.next[row][column] = next;
                    self.matters_before[row][column] = next.min(self.shadowed_from[row][column]);
                }
            }
        }
    }
}
