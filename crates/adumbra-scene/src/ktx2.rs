//! Images in KTX 2.0 files (Khronos). Decoding needs the feature `ktx2`.

#[cfg(feature = "ktx2")]
mod image;

#[cfg(feature = "ktx2")]
pub(crate) use image::Image;

/// The first bytes of a KTX2 file.
const IDENTIFIER: [u8; 12] = *b"\xABKTX 20\xBB\r\n\x1A\n";

/// Whether bytes are a KTX2 file.
pub(crate) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(&IDENTIFIER)
}
