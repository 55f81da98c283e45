//! First surfaces of a leaf's columns, and where the solids that are hit first end.

use super::texels::{LANES, rows_of};
use super::{Crossings, Leaf, Near};
use crate::columns::BLOCK_SIDE;
use crate::columns::seams::{self, SeamHit};
use crate::texel_mask::{texels_of, texels_where};
use crate::triangles::depth::{FixedDepth, depths_within};
use crate::triangles::project::SEAM_MARGIN;
use crate::triangles::surface::Surface;

/// Up to this many crossings, comparing each with all others is faster than sorting them.
const FEW_CROSSINGS: usize = 48;

impl Leaf<'_> {
    /// Samples surfaces from the light on, and skips columns that are resolved: no surface visited so far
    /// extends past the next one, and every solid that was entered has been left.
    #[inline(always)]
    pub(super) fn sample_all(&mut self, order: &[Near]) {
        let (mut reached, mut resolved) = (FixedDepth::MIN, 0);
        let mut are_masked_hidden = false;
        for near in order {
            let surface = &self.setting.surfaces[near.surface as usize].surface;
            if !surface.casts {
                continue;
            }
            if surface.masked {
                if !are_masked_hidden {
                    let wanted = self.inside & self.may_begin_from(near.low);
                    are_masked_hidden = wanted == 0;
                    self.sample_masked(near.surface, wanted);
                }
                continue;
            }
            if near.low > reached {
                let left = texels_where(|texel| self.entered.as_flattened()[texel] == 0);
                resolved = left & !self.may_begin_from(near.low);
            }
            reached = reached.max(near.high);
            self.sample(near, surface, resolved);
        }
    }

    #[inline(always)]
    fn sample(&mut self, near: &Near, surface: &Surface, resolved: u64) {
        let (block, rules) = (self.block, self.setting.rules);
        let shape = &surface.shape;
        let Some(plane) = shape.plane else { return };
        let [exact, grown] = if surface.solid && !shape.faces_sun {
            [shape.coverage(block.x, block.y, [0])[0]; 2]
        } else {
            shape.coverage(block.x, block.y, [0, SEAM_MARGIN])
        };
        let wanted = self.inside & !resolved;
        let covered = if surface.solid { exact } else { grown } & wanted;
        let seam = if surface.solid { grown & !exact & wanted } else { 0 };
        if exact & self.inside != 0
            && let Some(range) = &self.ranges[near.place as usize].sampled
        {
            for (row, texels) in rows_of(exact & self.inside) {
                for (c, deepest) in self.deepest[row].iter_mut().enumerate() {
                    let low = if texels[c] != 0 { range.lifted_low } else { FixedDepth::MIN };
                    *deepest = low.max(*deepest);
                }
            }
        }
        if covered | seam == 0 {
            return;
        }
        let mut depths = [[0; BLOCK_SIDE]; BLOCK_SIDE];
        let range = shape.depth_range();
        for (row, _) in rows_of(covered | seam) {
            depths[row] = depths_within(range, plane.along(&self.centers[0], self.centers[1][row]));
        }
        let depth = |texel: usize| depths.as_flattened()[texel];
        let info = rules.surface_info(shape.slope, surface.solid);
        let seams = texels_of(seam).map(|texel| SeamHit::new(texel, depth(texel), info, surface));
        self.buffers.seams.extend(seams);
        for (row, texels) in rows_of(covered) {
            self.first.add_row(row, texels, &depths[row], info, near.surface);
        }
        if surface.solid && covered != 0 {
            let leaves = !shape.faces_sun;
            let one = if leaves { -1 } else { 1 };
            for (row, texels) in rows_of(covered) {
                for (c, entered) in self.entered[row].iter_mut().enumerate() {
                    *entered += one & texels[c];
                }
            }
            let (low, high) = (near.low, near.high);
            self.buffers.crossings.push(Crossings { covered, leaves, low, high, depths });
        }
    }

    #[inline(always)]
    pub(super) fn add_seams(&mut self, order: &[Near]) {
        let Self { first, buffers, block, .. } = self;
        if !seams::keep_meeting_seams(&mut buffers.seams) {
            return;
        }
        for near in order {
            let surface = &self.setting.surfaces[near.surface as usize].surface;
            seams::drop_covered_seams(&mut buffers.seams, surface, |texel| {
                let (x, y) = ((texel % BLOCK_SIDE) as u32, (texel / BLOCK_SIDE) as u32);
                surface.shape.covers(i64::from(block.x + x), i64::from(block.y + y))
            });
        }
        seams::close_seams(&buffers.seams, |texel, surface| {
            if surface < first.get(texel) {
                first.set(texel, surface);
            }
        });
    }

    /// Writes to `base` the depth behind which other receivers matter: the end of the solid that is hit
    /// first, or the first surface itself.
    #[inline(always)]
    pub(super) fn resolve_solids(&mut self) {
        self.base = self.first.depth;
        let solid = texels_where(|texel| self.first.get(texel).is_solid());
        let crossings = &self.buffers.crossings;
        if crossings.len() > FEW_CROSSINGS {
            self.resolve_many_solids(solid);
            return;
        }
        let (mut crossed, mut ends) = (0, [[FixedDepth::MAX; BLOCK_SIDE]; BLOCK_SIDE]);
        for end in crossings {
            crossed |= end.covered;
            if !end.leaves {
                continue;
            }
            let undecided = solid & texels_where(|texel| ends.as_flattened()[texel] >= end.low);
            // A column ends here if it has left every solid that it entered up to this crossing.
            for (row, texels) in rows_of(end.covered & undecided) {
                let (mut inside, at) = ([0; BLOCK_SIDE], &end.depths[row]);
                for other in crossings.iter().take_while(|other| other.low <= end.high) {
                    let texels = other.covered >> (BLOCK_SIDE * row) & 0xff;
                    let (covered, one) = (&LANES[texels as usize], if other.leaves { -1 } else { 1 });
                    for c in 0..BLOCK_SIDE {
                        let counted = one & covered[c];
                        inside[c] += if other.depths[row][c] <= at[c] { counted } else { 0 };
                    }
                }
                for c in 0..BLOCK_SIDE {
                    let is_end = (texels[c] != 0) & (inside[c] <= 0);
                    let depth = if is_end { at[c] } else { FixedDepth::MAX };
                    ends[row][c] = depth.min(ends[row][c]);
                }
            }
        }
        let ended = texels_where(|texel| ends.as_flattened()[texel] != FixedDepth::MAX);
        for (base, &end) in self.base.as_flattened_mut().iter_mut().zip(ends.as_flattened()) {
            *base = if end == FixedDepth::MAX { *base } else { end };
        }
        for texel in texels_of(solid & crossed & !ended) {
            self.first.set_open(texel);
        }
    }

    /// Does what [`Self::resolve_solids`] does, texel by texel in order of depth. Sorting n crossings takes n
    /// log n steps, where comparing each with all others takes n².
    fn resolve_many_solids(&mut self, solid: u64) {
        let mut on_texel: Vec<(FixedDepth, i32)> = Vec::new();
        for texel in texels_of(solid) {
            let (row, column) = (texel / BLOCK_SIDE, texel % BLOCK_SIDE);
            on_texel.clear();
            let crossings = self.buffers.crossings.iter().filter(|c| c.covered >> texel & 1 != 0);
            on_texel.extend(crossings.map(|c| (c.depths[row][column], if c.leaves { -1 } else { 1 })));
            if on_texel.is_empty() {
                continue;
            }
            on_texel.sort_unstable();
            // Crossings at one depth count together. The column has left every solid that it entered where
            // the sum is not above 0.
            let mut inside = 0;
            let end = on_texel.chunk_by(|a, b| a.0 == b.0).find_map(|here| {
                inside += here.iter().map(|(_, one)| one).sum::<i32>();
                (inside <= 0 && here[0].1 < 0).then_some(here[0].0)
            });
            match end {
                Some(end) => self.base[row][column] = end,
                None => self.first.set_open(texel),
            }
        }
    }
}
