//! The words that the look-up shaders read: the same shaders with an access file that notes every word.

use adumbra::query::FixedReceiver;
use adumbra_shaders::constants::MAX_READS;
use adumbra_shaders::source;

use super::fixed;
use super::light::{BakedLight, queries};
use crate::error::{Fix, RenderError, Result};
use crate::gpu::Gpu;

/// Bytes of one answer of passes/voxel_reads.wgsl.
const ANSWER_BYTES: usize = 4 * (2 + MAX_READS as usize);
/// Receivers per pass: 64 MB of answers.
const BATCH: usize = (64 << 20) / ANSWER_BYTES;

/// A look-up and what it read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reads {
    /// Equals `Query::lit_taps` on the CPU.
    pub lit_taps: u32,
    /// Indices of the words, in the order in which they were read.
    pub words: Vec<u32>,
}

impl BakedLight {
    /// Looks up receivers in fixed point and returns what was read for each. The file's words must fit one binding.
    ///
    /// # Errors
    /// Returns [`RenderError::VoxelLimit`] if a look-up reads more than [`MAX_READS`] words, and any error that the
    /// device reports.
    pub fn reads(&self, gpu: &Gpu, receivers: &[FixedReceiver]) -> Result<Vec<Reads>> {
        let look_up: Vec<_> = self.look_up_with(source::WORDS_LOGGED);
        let files = [vec![source::SURFACE], look_up, vec![source::VOXEL_PASS, source::VOXEL_READS]].concat();
        let mut all = Vec::with_capacity(receivers.len());
        for batch in receivers.chunks(BATCH) {
            for answer in fixed::answer::<_, ANSWER_BYTES>(gpu, self.bindings(), &files, &queries(batch))? {
                let mut words = answer.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes));
                let (lit_taps, count) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
                if count > MAX_READS {
                    return Err(RenderError::VoxelLimit {
                        what: "the number of words that a look-up reads",
                        value: count.into(),
                        limit: MAX_READS.into(),
                        fix: Fix::Other("choose a narrower filter"),
                    });
                }
                all.push(Reads { lit_taps, words: words.take(count as usize).collect() });
            }
        }
        Ok(all)
    }
}
