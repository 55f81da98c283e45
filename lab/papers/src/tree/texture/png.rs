//! Converts a [`Page`] to PNG and back. Written PNGs are RGBA with 8 bits per channel and contain the chunks
//! IHDR, IDAT and IEND only, so that no reader has a reason to change colours. Only PNGs of the same pixel
//! format are read; anything that would need a conversion is refused.

use std::io::{self, Cursor, Write};

use png::{BitDepth, ColorType, Decoder, DecodingError, DeflateCompression, Encoder, Filter, Limits};

use crate::tree::error::TextureError;
use crate::tree::texture::{MAX_SIDE, Page};

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";
/// Bytes up to the end of the IHDR fields.
pub(crate) const HEADER_BYTES: usize = 29;
/// Maximum compression ratio of deflate.
const DEFLATE_RATIO: u64 = 1032;
/// Memory limit of the decoder besides the pixels: rows, and chunks that are skipped.
const DECODER_BYTES: usize = 64 << 20;

impl Page {
    /// Writes the page as a PNG.
    ///
    /// # Errors
    /// Returns the errors of `out`, and [`io::ErrorKind::InvalidInput`] if the bytes are not the pixels of
    /// the page.
    pub fn write_png(&self, out: impl Write) -> io::Result<()> {
        let mut encoder = Encoder::new(out, self.width, self.height);
        encoder.set_color(ColorType::Rgba);
        encoder.set_depth(BitDepth::Eight);
        // Equal words repeat, but neighbours are not similar as in a photograph. A filter doubles the size,
        // and a higher compression level gains little for the time it takes.
        encoder.set_filter(Filter::NoFilter);
        encoder.set_deflate_compression(DeflateCompression::Level(1));
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgba)?;
        Ok(writer.finish()?)
    }

    /// Decodes a PNG from its bytes.
    ///
    /// # Errors
    /// Returns [`TextureError`] if it is not an RGBA PNG with 8 bits per channel, is larger than [`MAX_SIDE`]
    /// or is damaged. The header is checked before anything is allocated.
    pub fn from_png(bytes: &[u8]) -> Result<Self, TextureError> {
        let [width, height] = check_header(bytes)?;
        let pixel_bytes = u64::from(width) * u64::from(height) * 4;
        if pixel_bytes > (bytes.len() as u64).saturating_mul(DEFLATE_RATIO) {
            let what = format!("{} bytes cannot hold {width} x {height} pixels", bytes.len());
            return Err(TextureError::Damaged { what });
        }
        let limits = Limits { bytes: pixel_bytes as usize + DECODER_BYTES };
        let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
        decoder.set_transformations(png::Transformations::IDENTITY);
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        let mut reader = decoder.read_info().map_err(damaged)?;
        let mut rgba = vec![0; pixel_bytes as usize];
        reader.next_frame(&mut rgba).map_err(damaged)?;
        reader.finish().map_err(damaged)?;
        Ok(Self { width, height, rgba })
    }
}

fn damaged(error: DecodingError) -> TextureError {
    let what = match error {
        DecodingError::IoError(e) if e.kind() == io::ErrorKind::UnexpectedEof => "it is cut off".to_owned(),
        other => other.to_string(),
    };
    TextureError::Damaged { what }
}

/// Returns width and height of a PNG of the supported format; needs the first [`HEADER_BYTES`] bytes.
pub(crate) fn check_header(bytes: &[u8]) -> Result<[u32; 2], TextureError> {
    if !bytes.starts_with(PNG_MAGIC) {
        return Err(TextureError::NotPng { found: kind_of(bytes) });
    }
    let Some(([_, _, _, _], [b'I', b'H', b'D', b'R', fields @ ..])) =
        bytes.get(PNG_MAGIC.len()..HEADER_BYTES).and_then(|b| b.split_first_chunk())
    else {
        return Err(TextureError::Damaged { what: "it does not begin with IHDR".to_owned() });
    };
    let side = |i: usize| u32::from_be_bytes([fields[i], fields[i + 1], fields[i + 2], fields[i + 3]]);
    let (width, height, bits, color) = (side(0), side(4), fields[8], fields[9]);
    match color {
        3 => return Err(TextureError::Palette),
        0 | 4 => return Err(TextureError::Grey),
        _ if bits == 16 => return Err(TextureError::SixteenBits),
        2 => return Err(TextureError::NoAlpha),
        6 if bits == 8 => {}
        _ => {
            let what = format!("colour type {color} with {bits} bits does not exist");
            return Err(TextureError::Damaged { what });
        }
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(TextureError::TooLarge { width, height });
    }
    Ok([width, height])
}

/// Describes bytes that are not a PNG by the format that they seem to have.
fn kind_of(bytes: &[u8]) -> String {
    let known: &[(&[u8], &str)] = &[
        (b"\xff\xd8\xff", "a JPEG, which loses bits"),
        (b"GIF8", "a GIF"),
        (b"BM", "a BMP"),
        (b"II*\0", "a TIFF"),
        (b"MM\0*", "a TIFF"),
        (b"\xabKTX", "a KTX texture"),
        (b"DDS ", "a DDS texture"),
        (b"ADUM", "a shadow file itself, which needs no import"),
    ];
    if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        return "a WebP".to_owned();
    }
    match known.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        Some((_, kind)) => (*kind).to_owned(),
        None if bytes.is_empty() => "empty".to_owned(),
        None => format!("a file that begins with \"{}\"", bytes[..bytes.len().min(8)].escape_ascii()),
    }
}
