//! The words that the look-up shaders read: runs the same shaders with an access file that records every
//! word.

use adumbra::query::FixedReceiver;
use adumbra_shaders::constants::MAX_READS;
use adumbra_shaders::layout::PointQuery;
use adumbra_shaders::{Source, source};

use super::VoxelBindings;
use super::light::{BakedLight, queries};
use super::{fixed, moving};
use crate::error::{Fix, RenderError, Result};
use crate::gpu::Gpu;

/// Bytes of one answer of passes/voxel_reads.wgsl.
const ANSWER_BYTES: usize = 4 * (2 + MAX_READS as usize);
/// Receivers per pass: 64 MB of answers.
const BATCH: usize = (64 << 20) / ANSWER_BYTES;

/// A look-up and the words that it read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reads {
    /// Equals `Sampler::lit_taps` on the CPU.
    pub lit_taps: u32,
    /// Indices of the words, in the order in which they were read.
    pub words: Vec<u32>,
}

/// Looks up receivers in fixed point and returns the words read for each. `look_up` are the WGSL files of the
/// look-up, except the access file. The words must fit one binding.
///
/// # Errors
/// Returns [`RenderError::VoxelLimit`] if a look-up reads more than [`MAX_READS`] words, and any error that
/// the device reports.
pub fn reads(
    gpu: &Gpu,
    bindings: &VoxelBindings,
    look_up: &[Source],
    receivers: &[FixedReceiver],
) -> Result<Vec<Reads>> {
    let passes = [source::WORDS_LOGGED, source::VOXEL_PARAMS, source::VOXEL_READS];
    let files = [&[source::SURFACE], look_up, &passes].concat();
    let mut all = Vec::with_capacity(receivers.len());
    for batch in receivers.chunks(BATCH) {
        for answer in fixed::answer::<_, ANSWER_BYTES>(gpu, bindings, &files, &queries(batch))? {
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

impl BakedLight {
    /// Looks up points, relative to the anchor, between the keys of a sun path. Returns the visibility and
    /// the number of words read for each.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn path_reads(&self, gpu: &Gpu, points: &[PointQuery]) -> Result<Vec<(f32, u32)>> {
        let files = [
            &[source::SURFACE],
            source::LOOK_UP,
            &[source::WORDS_LOGGED],
            moving::FILTER,
            &[source::PATH_READS],
        ];
        let mut all = Vec::with_capacity(points.len());
        for batch in points.chunks(BATCH) {
            for answer in fixed::answer::<_, ANSWER_BYTES>(gpu, self.bindings(), &files.concat(), batch)? {
                let mut words = answer.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes));
                let visibility = f32::from_bits(words.next().unwrap_or_default());
                all.push((visibility, words.next().unwrap_or_default()));
            }
        }
        Ok(all)
    }

    /// Looks up receivers in fixed point and returns the words read for each.
    ///
    /// # Errors
    /// Returns the errors of [`reads`].
    pub fn reads(&self, gpu: &Gpu, receivers: &[FixedReceiver]) -> Result<Vec<Reads>> {
        reads(gpu, self.bindings(), source::LOOK_UP, receivers)
    }
}
