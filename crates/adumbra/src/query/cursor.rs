//! Successive look-ups of neighbouring points.
//!
//! A filter touches the same few blocks of texels again and again, so the depths of the columns of the most
//! recent blocks are cached. The cache slot is chosen by the parity of the block, because a filter of up to 9
//! texels touches at most two along each axis.

use crate::query::columns::Columns;
use crate::query::{FixedReceiver, Sampler, receiver};

/// Look-ups that are cheaper if successive points are close to each other. They return what [`Sampler`]
/// returns.
pub struct Cursor<'s> {
    sampler: &'s Sampler,
    columns: Option<Columns<'s>>,
}

impl<'s> Cursor<'s> {
    /// Creates a cursor. Cost: 1 KB.
    pub fn new(sampler: &'s Sampler) -> Self {
        Self { sampler, columns: Columns::new(sampler.tree().words()) }
    }

    /// Returns the visibility of a world point, as [`Sampler::visibility`] does.
    pub fn visibility(&mut self, p_world: [f64; 3], normal: Option<[f64; 3]>) -> f32 {
        let sampler = self.sampler;
        let r = receiver(sampler.grid(), &sampler.bias(), p_world, normal);
        sampler.share(self.lit_taps(&FixedReceiver::new(&r, sampler.tree().size())))
    }

    /// Returns the number of lit taps, as [`Sampler::lit_taps`] does.
    pub fn lit_taps(&mut self, r: &FixedReceiver) -> u32 {
        self.sampler.taps_with(&mut self.columns, r)
    }
}
