//! Words in storage buffers: one buffer, or six if one binding cannot hold them.

use adumbra_shaders::{Source, source};
use wgpu::{BindingResource, BufferUsages};

use crate::error::{Fix, RenderError, Result};
use crate::gpu::Gpu;

/// Largest number of bindings that words are split over. With bindings of 128 MiB, the smallest limit of any
/// device, they hold 768 MiB.
pub const MAX_WORD_BINDINGS: usize = 6;

/// Words on the GPU, in the form that wgsl/access/words_1.wgsl or words_6.wgsl reads.
pub struct WordBuffers {
    buffers: Vec<wgpu::Buffer>,
    words: u64,
}

impl WordBuffers {
    /// Uploads `parts` one after the other. Cost: one copy in device memory and, until the upload is done,
    /// one in the queue's.
    ///
    /// # Errors
    /// Returns [`RenderError::TooLarge`] if [`MAX_WORD_BINDINGS`] bindings cannot hold them.
    pub fn new(gpu: &Gpu, label: &str, parts: &[&[u32]]) -> Result<Self> {
        let words = parts.iter().map(|p| p.len() as u64).sum();
        let found = Self::empty(gpu, label, words)?;
        let mut at = 0_u64;
        for part in parts {
            found.write(gpu, at, part);
            at += part.len() as u64;
        }
        gpu.check()?;
        Ok(found)
    }

    /// Writes words starting at index `at`.
    pub(super) fn write(&self, gpu: &Gpu, mut at: u64, mut words: &[u32]) {
        let capacity = self.buffers[0].size() / 4;
        while !words.is_empty() {
            let (index, within) = (at / capacity, at % capacity);
            let (now, later) = words.split_at(words.len().min((capacity - within) as usize));
            gpu.queue.write_buffer(&self.buffers[index as usize], within * 4, bytemuck::cast_slice(now));
            at += now.len() as u64;
            words = later;
        }
    }

    /// Creates buffers for `words` words, all zero.
    ///
    /// # Errors
    /// Returns the errors of [`WordBuffers::new`].
    pub fn empty(gpu: &Gpu, label: &str, words: u64) -> Result<Self> {
        let limits = gpu.device.limits();
        let max_bytes = gpu.max_binding_bytes.min(limits.max_buffer_size);
        let max_bindings =
            if limits.max_storage_buffers_per_shader_stage < 8 { 1 } else { MAX_WORD_BINDINGS as u64 };
        let sizes = split(words, max_bytes, max_bindings).ok_or(RenderError::TooLarge {
            what: label.to_owned(),
            bytes: words * 4,
            limit: capacity(max_bytes) * 4 * max_bindings,
            fix: Fix::LowerResolution,
        })?;
        let buffer = |words: &u64| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: (words * 4).max(4),
                usage: BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            })
        };
        Ok(Self { buffers: sizes.iter().map(buffer).collect(), words })
    }

    /// The WGSL file that reads the buffers.
    pub fn access(&self) -> Source {
        if self.buffers.len() == 1 { source::WORDS_1 } else { source::WORDS_6 }
    }

    /// The buffers, in order.
    pub fn buffers(&self) -> &[wgpu::Buffer] {
        &self.buffers
    }

    /// Bytes of the words.
    pub fn bytes(&self) -> u64 {
        self.words * 4
    }

    pub(super) fn resources(&self) -> Vec<BindingResource<'_>> {
        self.buffers.iter().map(wgpu::Buffer::as_entire_binding).collect()
    }
}

/// Words per binding if there are several bindings: a power of two.
fn capacity(max_bytes: u64) -> u64 {
    1 << (max_bytes / 4).max(1).ilog2()
}

/// Words of each buffer: one buffer, or [`MAX_WORD_BINDINGS`] with one word in each unused one. `None` if the
/// words do not fit.
fn split(words: u64, max_bytes: u64, max_bindings: u64) -> Option<Vec<u64>> {
    if words * 4 <= max_bytes {
        return Some(vec![words]);
    }
    let capacity = capacity(max_bytes);
    if words > capacity * max_bindings {
        return None;
    }
    let size = |i| words.saturating_sub(i * capacity).clamp(1, capacity);
    Some((0..MAX_WORD_BINDINGS as u64).map(size).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_split_by_powers_of_two_up_to_six_bindings() {
        assert_eq!(split(100, 400, 6), Some(vec![100]));
        assert_eq!(split(101, 400, 6), Some(vec![64, 37, 1, 1, 1, 1]));
        assert_eq!(split(6 * 64, 400, 6), Some(vec![64; 6]));
        assert_eq!(split(6 * 64 + 1, 400, 6), None);
        assert_eq!(split(101, 400, 1), None);
        let mib = 1 << 20;
        assert_eq!(capacity(128 * mib) * 4 * MAX_WORD_BINDINGS as u64, 768 * mib);
    }
}
