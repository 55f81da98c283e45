//! Further look-ups of a light-aligned file: a column's switch depth, and penumbrae.

use adumbra::query::FixedReceiver;
use adumbra_shaders::source;

use super::fixed;
use super::light::{BakedLight, queries};
use crate::error::Result;
use crate::gpu::Gpu;

/// Results of all look-ups, for a receiver in fixed point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthsAnswer {
    /// Equals `Sampler::lit_taps` on the CPU.
    pub lit_taps: u32,
    /// Equals [`adumbra::layout::depths::DepthTree::value`] for the receiver's column, clamped to the grid's
    /// border.
    pub value: u32,
    /// Equals [`super::SoftTwin`] with the receiver's index in the list as pixel (x, 0).
    pub soft: f32,
}

impl BakedLight {
    /// Runs all look-ups of the shaders for receivers in fixed point.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn depths_answers(&self, gpu: &Gpu, receivers: &[FixedReceiver]) -> Result<Vec<DepthsAnswer>> {
        let files = [vec![source::SURFACE], self.soft_sources(), vec![source::DEPTHS_FIXED]].concat();
        let answers = fixed::answer::<_, 12>(gpu, self.bindings(), &files, &queries(receivers))?;
        let read = |bytes: [u8; 12]| {
            let [lit_taps, value, soft] = [0, 4, 8]
                .map(|at| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]));
            DepthsAnswer { lit_taps, value, soft: f32::from_bits(soft) }
        };
        Ok(answers.into_iter().map(read).collect())
    }
}
