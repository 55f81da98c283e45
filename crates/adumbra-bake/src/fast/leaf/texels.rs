//! Values and sets of texels of a leaf, by row, and the first surfaces of its columns.

use crate::columns::BLOCK_SIDE;
use crate::columns::rules::FirstSurface;
use crate::texel_mask::texels_where;
use crate::triangles::depth::FixedDepth;

/// One value per texel, by row and column. Compilers vectorize loops over rows of eight.
pub(super) type Texels<T> = [[T; BLOCK_SIDE]; BLOCK_SIDE];
/// Owner of a texel whose first surface is not a single surface of the list.
const NO_OWNER: u32 = u32::MAX;

/// The first surfaces of a leaf's columns.
pub(super) struct Firsts {
    /// Depths and infos of [`FirstSurface`].
    pub(super) depth: Texels<FixedDepth>,
    pub(super) info: Texels<u32>,
    /// Index into [`Setting::surfaces`] of the surface that is first.
    pub(super) owner: Texels<u32>,
}

impl Firsts {
    #[inline(always)]
    pub(super) fn none() -> Self {
        let none = FirstSurface::NONE;
        Self {
            depth: [[none.depth(); BLOCK_SIDE]; BLOCK_SIDE],
            info: [[none.info(); BLOCK_SIDE]; BLOCK_SIDE],
            owner: [[NO_OWNER; BLOCK_SIDE]; BLOCK_SIDE],
        }
    }

    #[inline(always)]
    pub(super) fn get(&self, texel: usize) -> FirstSurface {
        FirstSurface::new(self.depth.as_flattened()[texel], self.info.as_flattened()[texel])
    }

    /// Makes this the first surface of a column, with no owner.
    pub(super) fn set(&mut self, texel: usize, first: FirstSurface) {
        self.depth.as_flattened_mut()[texel] = first.depth();
        self.info.as_flattened_mut()[texel] = first.info();
        self.owner.as_flattened_mut()[texel] = NO_OWNER;
    }

    pub(super) fn set_open(&mut self, texel: usize) {
        let mut first = self.get(texel);
        first.set_open();
        self.info.as_flattened_mut()[texel] = first.info();
    }

    /// Returns the columns that have a first surface.
    #[inline(always)]
    pub(super) fn met(&self) -> u64 {
        texels_where(|texel| !self.get(texel).is_none())
    }

    /// Adds a surface with these depths to the texels `covered` of a row.
    #[inline(always)]
    pub(super) fn add_row(
        &mut self,
        row: usize,
        covered: &Lanes,
        depths: &[FixedDepth; BLOCK_SIDE],
        info: u32,
        owner: u32,
    ) {
        let (depth, infos, owners) = (&mut self.depth[row], &mut self.info[row], &mut self.owner[row]);
        for c in 0..BLOCK_SIDE {
            let d = depths[c];
            let is_first = (d < depth[c]) | (d == depth[c]) & (info < infos[c]);
            let is_new = is_first & (covered[c] != 0);
            depth[c] = if is_new { d } else { depth[c] };
            infos[c] = if is_new { info } else { infos[c] };
            owners[c] = if is_new { owner } else { owners[c] };
        }
    }
}

/// The texels of a set in one row: all bits of a lane, or none.
pub(super) type Lanes = [i32; BLOCK_SIDE];

/// The lanes of every row of eight bits.
pub(super) static LANES: [Lanes; 256] = {
    let mut lanes = [[0; BLOCK_SIDE]; 256];
    let mut i = 0;
    while i < 256 * BLOCK_SIDE {
        let (row, column) = (i / BLOCK_SIDE, i % BLOCK_SIDE);
        lanes[row][column] = -((row >> column & 1) as i32);
        i += 1;
    }
    lanes
};

/// Iterates over the rows of `mask` that have texels: number and texels of the row.
#[inline(always)]
pub(super) fn rows_of(mask: u64) -> impl Iterator<Item = (usize, &'static Lanes)> {
    let rows = mask.to_le_bytes().into_iter().enumerate();
    rows.filter(|(_, texels)| *texels != 0).map(|(row, texels)| (row, &LANES[usize::from(texels)]))
}
