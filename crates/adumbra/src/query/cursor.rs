//! Look-ups one after the other, of points that are neighbours.
//!
//! A filter touches the same few blocks of texels again and again, often at the same depth: the last slab of each is kept, in four places by
//! the parity of the block, as a filter of up to 9 texels touches two along each axis. What is not kept is looked up from the lowest node on that
//! the last look-up's way has in common with it.

use super::{FixedReceiver, Query, receiver};
use crate::dag::Trail;

/// A [`Query`] that remembers where it has been. Its answers are the query's, to the bit.
pub struct Cursor<'d> {
    query: Query<'d>,
    trail: Trail,
    /// By parity of block x and block y: block x, block y, layer, and the slab.
    kept: [([u32; 3], u64); 4],
}

impl<'d> Cursor<'d> {
    /// A cursor that has been nowhere yet.
    pub fn new(query: Query<'d>) -> Self {
        Self { query, trail: Trail::new(), kept: [([u32::MAX; 3], 0); 4] }
    }

    /// As [`Query::visibility`].
    pub fn visibility(&mut self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        let Query { grid, slabs, bias, filter } = self.query;
        let r = receiver(grid, &bias, p_world, normal);
        let lit = self.lit_taps(&FixedReceiver::new(&r, slabs.size()));
        lit as f32 / (filter * filter) as f32
    }

    /// As [`Query::lit_taps`].
    pub fn lit_taps(&mut self, r: &FixedReceiver) -> u32 {
        let Self { query, trail, kept } = self;
        query.lit_taps_of(r, |i, j, k| {
            let place = [i >> 3, j >> 3, k];
            let (kept_place, slab) = &mut kept[(place[0] & 1 | (place[1] & 1) << 1) as usize];
            if *kept_place != place {
                (*kept_place, *slab) = (place, query.slabs.slab_along(trail, i, j, k));
            }
            *slab
        })
    }
}
