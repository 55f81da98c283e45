//! Limits on the size and number of pages.

/// Minimum value of the largest side, pixels.
pub const MIN_SIDE: u32 = 64;
/// Maximum pixels per side, which every current GPU supports.
pub const MAX_SIDE: u32 = 8192;
/// Maximum number of pages of an export.
pub const MAX_PAGES: u32 = 4096;
