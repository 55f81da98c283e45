//! Limits for streams.

use adumbra::gpu::HEADER_WORDS;
use adumbra::stream::StreamOptions;
use bevy::ecs::prelude::*;
use bevy::reflect::prelude::*;

/// The largest number of levels of a file.
const MAX_LEVELS: u32 = 8;

/// Limits for streamed files. A resource. A change of any field except `upload_bytes_per_frame` reopens the
/// files; resident data answers until they are open.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct StreamBudget {
    /// Bytes of texture memory for each streamed file, and as many in main memory. The default is 32 MiB.
    pub bytes: u64,
    /// Bytes that are written to textures per frame, for all streamed files together. The default is 256 KiB.
    pub upload_bytes_per_frame: usize,
    /// The largest number of pixels that a texel may cover. The default is 1. Less is sharper, and needs more
    /// bytes; with 0 the whole file is requested.
    pub detail_pixels: f64,
    /// Number of frames over which pages fade in and out, so that shadows do not jump. The default, 0,
    /// switches them at once.
    pub fade_frames: u32,
}

impl Default for StreamBudget {
    fn default() -> Self {
        let StreamOptions { budget_bytes, detail_pixels, fade_frames, .. } = StreamOptions::default();
        Self { bytes: budget_bytes, upload_bytes_per_frame: 256 << 10, detail_pixels, fade_frames }
    }
}

impl StreamBudget {
    /// Returns the options of a stream. The first header of its texture precedes the words of the pool.
    pub(super) fn options(&self) -> StreamOptions {
        let header_bytes = 4 * HEADER_WORDS as u64;
        StreamOptions {
            budget_bytes: self.bytes.saturating_sub(header_bytes),
            // Avoid zero: texels are divided by it.
            detail_pixels: self.detail_pixels.max(1e-9),
            reserved_words: HEADER_WORDS as u32 * (MAX_LEVELS - 1),
            fade_frames: self.fade_frames,
        }
    }
}
