//! What streams may take.

use adumbra::gpu::HEADER_WORDS;
use adumbra::stream::StreamOptions;
use bevy::ecs::prelude::*;
use bevy::reflect::prelude::*;

/// The largest number of levels of a file.
const MAX_LEVELS: u32 = 8;

/// What streamed files may take. A resource. After a change of anything but
/// `upload_bytes_per_frame` files are opened anew, and what
/// was resident answers until they are.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
pub struct StreamBudget {
    /// Bytes of a texture that each streamed file has, and as many in main memory. 32 MiB unless set.
    pub bytes: u64,
    /// Bytes that are written to textures per frame, of all streamed files together. 256 KiB unless set.
    pub upload_bytes_per_frame: usize,
    /// The largest number of pixels that a texel may cover, 1 unless set. Less is sharper, and needs more bytes; with 0
    /// all of a file is asked for.
    pub detail_pixels: f64,
    /// Frames over which pages come and go, so that shadows do not jump. 0, unless set, changes them at once.
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
            // Not zero, by which texels are divided.
            detail_pixels: self.detail_pixels.max(1e-9),
            reserved_words: HEADER_WORDS as u32 * (MAX_LEVELS - 1),
            fade_frames: self.fade_frames,
        }
    }
}
