//! Settings of a stream, and its counters.

/// Settings of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StreamOptions {
    /// Bytes of the pool: 32 MiB unless set, at most 8 GiB.
    pub budget_bytes: u64,
    /// The largest number of pixels that a texel may cover, 1 unless set. Less is sharper, and needs more
    /// bytes.
    pub detail_pixels: f64,
    /// Words that the host puts before all others, such as the headers of a look-up texture's levels.
    pub reserved_words: u32,
    /// Number of updates over which pages fade in and out: meanwhile look-ups mix them with the next coarser
    /// level, so that shadows do not jump. 0 (the default) and 1 change them immediately.
    pub fade_frames: u32,
}

impl StreamOptions {
    /// Whether pages fade in and out.
    pub(super) fn fades(&self) -> bool {
        self.fade_frames > 1
    }
}

impl Default for StreamOptions {
    fn default() -> Self {
        Self { budget_bytes: 32 << 20, detail_pixels: 1.0, reserved_words: 0, fade_frames: 0 }
    }
}

/// The work that a stream has done, and the work that is left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct StreamCounts {
    /// Requests that have been answered.
    pub requests: u64,
    /// Bytes that the answers had.
    pub bytes: u64,
    /// Length of the file; 0 until it is known.
    pub file_bytes: u64,
    /// Bytes of the words of all levels once they are decoded. A budget of this size plus a tenth holds the
    /// whole file. 0 until it is known.
    pub decoded_bytes: u64,
    /// Bytes of the pool that are in use.
    pub resident_bytes: u64,
    /// Bundles that have pages in the pool.
    pub resident_bundles: u32,
    /// Bundles that views need and that fit the budget.
    pub chosen_bundles: u32,
    /// Chosen bundles that are not resident yet.
    pub missing_bundles: u32,
    /// Bytes that are in memory, and have still to be written to the pool.
    pub queued_bytes: u64,
}
