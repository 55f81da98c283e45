//! Successive look-ups of neighbouring points.
//!
//! A filter touches the same few blocks of texels again and again, so the most recent blocks are cached: the depths of
//! their columns if the layout stores them, else cubes of leaf masks, often at the same depth. The cache slot is chosen
//! by the parity of the block, because a filter of up to 9 texels touches at most two along each axis, and by a cube's
//! index along the light. For a cube that is not cached, the traversal starts at the lowest node that it shares with the
//! previous look-up.

use crate::query::columns::Columns;
use crate::query::taps::Cubes;
use crate::query::{FixedReceiver, Query, receiver};

/// A [`Query`] that caches its recent look-ups. It is faster for successive points that are close to each other, and
/// its results equal those of the query bit for bit.
pub struct Cursor<'d> {
    query: Query<'d>,
    cache: Cache<'d>,
}

#[expect(clippy::large_enum_variant, reason = "a cursor is made once for many look-ups")]
enum Cache<'d> {
    Columns(Columns<'d>),
    Cubes(Cubes<'d, 32>),
}

impl<'d> Cursor<'d> {
    /// Creates a cursor with an empty cache.
    pub fn new(query: Query<'d>) -> Self {
        let columns = Columns::new(query.leaf_masks).map(Cache::Columns);
        Self { query, cache: columns.unwrap_or_else(|| Cache::Cubes(Cubes::new(query.leaf_masks))) }
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
        match &mut self.cache {
            Cache::Columns(columns) => columns.lit_taps(self.query.filter, r),
            Cache::Cubes(cubes) => cubes.lit_taps(self.query.filter, r),
        }
    }
}
