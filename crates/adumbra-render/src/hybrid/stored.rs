//! GPU buffers of a hybrid map in either layout, which the place passes write and look-ups read.
//!
//! | layout | bytes |
//! |---|---|
//! | compact | words: 4 per coarsest or finer texel, but 2 per finest texel with 16-bit depth |
//! | paper | texels: 16 each; links: 8 per texel below the coarsest level |

use wgpu::{BindingResource, BufferUsages};

use super::settings::{HybridLayout, HybridSettings};
use crate::error::{Fix, RenderError, Result};
use crate::gpu::Gpu;
use crate::maps::DepthPrecision;
use crate::readback::read_buffer;

/// Buffers of a map.
pub(super) enum Stored {
    /// Layout of access/hybrid_compact.wgsl.
    Compact { words: wgpu::Buffer },
    /// Layout of access/hybrid_paper.wgsl.
    Paper { texels: wgpu::Buffer, links: wgpu::Buffer },
}

/// Size of a built map, and the number of blocks that did not merge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltCounts {
    /// 32-bit words in use. The paper's layout takes four per texel and two per link.
    pub words: u32,
    /// Texels in use: the coarsest, plus four per block that did not merge.
    pub texels: u32,
    /// Blocks that did not merge, by level from 1.
    pub split: [u32; 3],
}

impl Stored {
    /// Allocates room for the largest map of these settings, or as much of it as one binding holds.
    ///
    /// # Errors
    /// Returns [`RenderError::TooLarge`] if a binding holds less than the coarsest level.
    pub(super) fn largest(gpu: &Gpu, settings: &HybridSettings) -> Result<Self> {
        let target = u64::from(settings.target).pow(2);
        let room = |each: u64| -> Result<u64> {
            check_binding(gpu, settings, target * each)?;
            Ok(max_entries(settings).min(binding_limit(gpu) / each / 4 * 4))
        };
        Ok(match settings.layout {
            HybridLayout::Compact => Self::Compact { words: buffer(gpu, "hybrid::words", 4 * room(4)?) },
            HybridLayout::Paper => {
                let places = room(16)?;
                Self::Paper {
                    texels: buffer(gpu, "hybrid::texels", 16 * places),
                    links: buffer(gpu, "hybrid::links", 8 * (places - target).max(4)),
                }
            }
        })
    }

    /// Capacity: words for the compact layout, texels for the paper's.
    pub(super) fn room(&self) -> u32 {
        match self {
            Self::Compact { words } => (words.size() / 4) as u32,
            Self::Paper { texels, .. } => (texels.size() / 16) as u32,
        }
    }

    /// Whether a map of these settings may exceed the capacity.
    pub(super) fn may_run_out(&self, settings: &HybridSettings) -> bool {
        u64::from(self.room()) < max_entries(settings)
    }

    /// Copies the part in use into buffers of that size.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub(super) fn kept(&self, gpu: &Gpu, counts: &BuiltCounts) -> Result<Self> {
        let mut encoder = gpu.encoder("hybrid::keep");
        let mut copy = |from: &wgpu::Buffer, bytes: u64| {
            // A binding of vec4u holds at least one element.
            let to = buffer(gpu, "hybrid::kept", bytes.next_multiple_of(16).clamp(16, from.size()));
            encoder.copy_buffer_to_buffer(from, 0, &to, 0, to.size());
            to
        };
        let kept = match self {
            Self::Compact { words } => Self::Compact { words: copy(words, 4 * u64::from(counts.words)) },
            Self::Paper { texels, links } => {
                let listed = 4 * counts.split.iter().map(|&n| u64::from(n)).sum::<u64>();
                Self::Paper {
                    texels: copy(texels, 16 * u64::from(counts.texels)),
                    links: copy(links, 8 * listed),
                }
            }
        };
        gpu.finish(encoder.finish())?;
        Ok(kept)
    }

    /// Resources for bindings 1 and 2 of look-ups.
    pub(super) fn bindings(&self) -> [BindingResource<'_>; 2] {
        match self {
            Self::Compact { words } => [words.as_entire_binding(), words.as_entire_binding()],
            Self::Paper { texels, links } => [texels.as_entire_binding(), links.as_entire_binding()],
        }
    }

    /// Reads back all 32-bit words of the buffers, including unused room. The second vector is empty for the
    /// compact layout.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub(super) fn read(&self, gpu: &Gpu) -> Result<[Vec<u32>; 2]> {
        let words = |buffer| -> Result<Vec<u32>> {
            let bytes = read_buffer(gpu, buffer)?;
            Ok(bytes.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b)).collect())
        };
        Ok(match self {
            Self::Compact { words: all } => [words(all)?, Vec::new()],
            Self::Paper { texels, links } => [words(texels)?, words(links)?],
        })
    }

    /// Bytes on the GPU.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Compact { words } => words.size(),
            Self::Paper { texels, links } => texels.size() + links.size(),
        }
    }
}

/// Number of entries of the largest map: words for the compact layout, texels for the paper's.
fn max_entries(settings: &HybridSettings) -> u64 {
    let texels = |level: u32| u64::from(settings.start >> level).pow(2);
    let halves = settings.layout == HybridLayout::Compact && settings.depth == DepthPrecision::Bits16;
    let finest = texels(0) / if halves { 2 } else { 1 };
    (finest + (1..=settings.merges()).map(texels).sum::<u64>()).next_multiple_of(4)
}

fn binding_limit(gpu: &Gpu) -> u64 {
    gpu.max_binding_bytes.min(gpu.device.limits().max_buffer_size)
}

/// Checks that the device can bind a buffer of `bytes`.
///
/// # Errors
/// Returns [`RenderError::TooLarge`] if it cannot.
pub(super) fn check_binding(gpu: &Gpu, settings: &HybridSettings, bytes: u64) -> Result<()> {
    if bytes <= binding_limit(gpu) { Ok(()) } else { Err(too_large(gpu, settings, bytes)) }
}

/// The error that a map takes more bytes than one binding holds.
pub(super) fn too_large(gpu: &Gpu, settings: &HybridSettings, bytes: u64) -> RenderError {
    RenderError::TooLarge {
        what: format!("a hybrid shadow map of {} texels per side", settings.start),
        bytes,
        limit: binding_limit(gpu),
        fix: Fix::Other(match settings.layout {
            HybridLayout::Compact => "give a smaller START",
            HybridLayout::Paper => "give layout=compact, or a smaller START",
        }),
    }
}

/// Creates a storage buffer that can be copied from and to.
pub(super) fn buffer(gpu: &Gpu, label: &str, size: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn max_entries_match_an_unmerged_map() {
        let most = |name: &str| max_entries(&HybridSettings::from_spec(&name.parse().unwrap()).unwrap());
        let texels = (1024 + 512) * (1024 + 512) - 2 * 1024 * 512 + 256 * 256;
        assert_eq!(most("hrsm:1024-256"), texels);
        assert_eq!(most("hrsm:1024-256:layout=paper:depth=16"), texels);
        assert_eq!(most("hrsm:1024-256:depth=16"), texels - 1024 * 512);
    }
}
