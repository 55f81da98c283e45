//! Look-ups one after the other, of points that are neighbours.
//!
//! A filter touches the same few blocks of texels again and again, often at the same depth: the last cubes of each are
//! kept, by the parity of the block, as a filter of up to 9 texels touches two along each axis, and by the cube's place along the
//! light. What is not kept is looked up from the lowest node on that the last look-up's way has in common with it.

use super::taps::Cubes;
use super::{FixedReceiver, Query, receiver};

/// A [`Query`] that remembers where it has been. Its answers are the query's, to the bit.
pub struct Cursor<'d> {
    query: Query<'d>,
    cubes: Cubes<'d, 32>,
}

impl<'d> Cursor<'d> {
    /// A cursor that has been nowhere yet.
    pub fn new(query: Query<'d>) -> Self {
        Self { query, cubes: Cubes::new(query.slabs) }
    }

    /// As [`Query::visibility`].
    pub fn visibility(&mut self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        let Query { grid, slabs, bias, filter, .. } = self.query;
        let r = receiver(grid, &bias, p_world, normal);
        let lit = self.lit_taps(&FixedReceiver::new(&r, slabs.size()));
        lit as f32 / (filter * filter) as f32
    }

    /// As [`Query::lit_taps`].
    pub fn lit_taps(&mut self, r: &FixedReceiver) -> u32 {
        self.cubes.lit_taps(self.query.filter, self.query.layers, r)
    }
}
