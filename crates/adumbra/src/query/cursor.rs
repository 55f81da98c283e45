//! Successive look-ups of neighbouring points.
//!
//! A filter touches the same few blocks of texels again and again, often at the same depth, so the most recent cubes of
//! each block are cached. The cache slot is chosen by the parity of the block, because a filter of up to 9 texels
//! touches at most two along each axis, and by the cube's index along the light. On a miss, the traversal starts at the
//! lowest node that it shares with the previous look-up.

use crate::query::taps::Cubes;
use crate::query::{FixedReceiver, Query, receiver};

/// A [`Query`] that caches its recent look-ups. It is faster for successive points that are close to each other, and
/// its results equal those of the query bit for bit.
pub struct Cursor<'d> {
    query: Query<'d>,
    cubes: Cubes<'d, 32>,
}

impl<'d> Cursor<'d> {
    /// Creates a cursor with an empty cache.
    pub fn new(query: Query<'d>) -> Self {
        Self { query, cubes: Cubes::new(query.leaf_masks) }
    }

    /// Returns the visibility of a world point, 1 = lit. See [`Query::visibility`].
    pub fn visibility(&mut self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        let Query { grid, leaf_masks, bias, filter, .. } = self.query;
        let r = receiver(grid, &bias, p_world, normal);
        let lit = self.lit_taps(&FixedReceiver::new(&r, leaf_masks.size()));
        lit as f32 / (filter * filter) as f32
    }

    /// Returns the number of lit taps. See [`Query::lit_taps`].
    pub fn lit_taps(&mut self, r: &FixedReceiver) -> u32 {
        self.cubes.lit_taps(self.query.filter, r)
    }
}
