//! Images in KTX 2.0 files with Basis Universal texels (ETC1S and UASTC LDR), as the glTF extension
//! `KHR_texture_basisu` allows them: two-dimensional, one layer. Other KTX2 files are rejected with the name
//! of their format. Sources: the KTX File Format Specification 2.0 and the Khronos Data Format Specification
//! 1.3.
//!
//! The container is read here, and only the first mip level is kept. The transcoder gets a new container
//! written here, so that it never follows the file's own offsets. Departures: sizes need not be multiples of
//! four, and the keys `KTXorientation` and `KTXswizzle`, which the extension fixes, are not read.

use std::io::Read;

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use ruzstd::decoding::StreamingDecoder;

use super::IDENTIFIER;

/// Length of the file's header, bytes.
const HEADER: usize = 80;
/// Length of an entry of the index of levels, bytes.
const LEVEL_ENTRY: usize = 24;
/// Length of the header of the BasisLZ codebooks, and of each of their image descriptions, bytes.
const CODEBOOK_PART: usize = 20;
/// Length of a UASTC block, bytes.
const UASTC_BLOCK: u64 = 16;
/// A stream's window may have this size even if the image is smaller, bytes: RFC 8878 recommends this limit.
const ZSTD_WINDOW: u64 = 8 << 20;
/// Memory that the transcoder takes per block of 4 × 4 texels besides its output, bytes.
const BYTES_PER_BLOCK: u64 = 16;
/// Memory that the transcoder takes for its tables and codebooks, bytes.
const TABLES: u64 = 8 << 20;

/// A KTX2 image whose header has been checked.
pub(crate) struct Image<'a> {
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// The data format descriptor.
    format: &'a [u8],
    texels: Texels<'a>,
}

/// The stored texels of the first mip level.
enum Texels<'a> {
    /// BasisLZ: the header of the codebooks, their data, and the slices of colour and of alpha.
    Etc1s { header: &'a [u8], books: &'a [u8], slices: [&'a [u8]; 2] },
    /// Blocks, and whether they are compressed with Zstandard.
    Uastc { blocks: &'a [u8], zstd: bool },
}

impl<'a> Image<'a> {
    /// Reads a file's header. The error is a clause about the image.
    pub(crate) fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let cut_off = || "the KTX2 file is cut off".to_owned();
        let header = bytes.first_chunk::<HEADER>().ok_or_else(cut_off)?;
        let [vulkan, _, width, height, depth, layers, faces, _, scheme] =
            std::array::from_fn(|i| word(header, IDENTIFIER.len() + 4 * i));
        if vulkan != 0 {
            return Err(format!(
                "it is a KTX2 file in the Vulkan format {vulkan}{}, not in Basis Universal",
                vulkan_name(vulkan)
            ));
        }
        if width == 0 || height == 0 || depth > 0 || layers > 1 || faces != 1 {
            return Err("it is a KTX2 file of another kind than one two-dimensional image".to_owned());
        }
        let part = |offset: u64, length: u64| -> Option<&'a [u8]> {
            let end = usize::try_from(offset.checked_add(length)?).ok()?;
            bytes.get(usize::try_from(offset).ok()?..end)
        };
        let format = part(word(header, 48).into(), word(header, 52).into()).ok_or_else(cut_off)?;
        let level = part(HEADER as u64, LEVEL_ENTRY as u64).ok_or_else(cut_off)?;
        let level = part(long(level, 0), long(level, 8)).ok_or_else(cut_off)?;
        // After 28 bytes there are samples of 16 bytes: one for colour, and a second one if there is alpha.
        let samples = (format.len() as u64).checked_sub(28).filter(|n| [16, 32].contains(n)).map(|n| n / 16);
        let (Some(samples), model) = (samples, byte(format, 12)) else {
            return Err("the KTX2 file has an unknown data format descriptor".to_owned());
        };
        let texels = match (model, scheme) {
            (163, 1) => {
                let data = part(long(header, 64), long(header, 72)).ok_or_else(cut_off)?;
                let texels = etc1s(data, level, word(header, 40).max(1), samples == 2);
                texels.ok_or_else(|| "its ETC1S data reaches past the KTX2 file".to_owned())?
            }
            (166, 0 | 2) => Texels::Uastc { blocks: level, zstd: scheme == 2 },
            (163 | 166, _) => return Err(format!("its KTX2 supercompression scheme {scheme} is unknown")),
            _ => {
                return Err(format!(
                    "it is a KTX2 file in the colour model {model}{}, not in ETC1S or UASTC",
                    model_name(model)
                ));
            }
        };
        Ok(Self { width, height, format, texels })
    }

    /// Memory held while the image is decoded, including its result of four bytes per texel, bytes.
    pub(crate) fn peak_bytes(&self) -> u64 {
        let packed = match &self.texels {
            Texels::Etc1s { header, books, slices: [color, alpha] } => {
                (header.len() + books.len() + color.len() + alpha.len()) as u64
            }
            Texels::Uastc { zstd: false, .. } => self.uastc_bytes(),
            Texels::Uastc { zstd: true, .. } => self.uastc_bytes() + 2 * self.window(),
        };
        let texels = u64::from(self.width) * u64::from(self.height);
        4 * texels + self.blocks() * BYTES_PER_BLOCK + packed + TABLES
    }

    /// The texels of the first mip level, red, green, blue and alpha, row by row. The error is a clause about
    /// the image.
    pub(crate) fn rgba(&self) -> Result<Vec<u8>, String> {
        let broken = || "its Basis Universal data is broken".to_owned();
        let file = self.repack()?;
        let transcoder = Transcoder::new(&file).map_err(|_| broken())?;
        let texels =
            transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(|_| broken())?;
        let expected = u64::from(self.width) * u64::from(self.height) * 4;
        if texels.len() as u64 == expected { Ok(texels) } else { Err(broken()) }
    }

    /// Writes a KTX2 file of the first mip level alone, without keys and without Zstandard.
    fn repack(&self) -> Result<Vec<u8>, String> {
        let format_at = HEADER + LEVEL_ENTRY;
        let global_at = format_at + self.format.len();
        let mut global = Vec::new();
        let mut level = Vec::new();
        let scheme: u32 = match &self.texels {
            Texels::Etc1s { header, books, slices: [color, alpha] } => {
                global.extend_from_slice(header);
                let lengths = [color.len(), alpha.len()].map(|n| n as u32);
                for word in [0, 0, lengths[0], lengths[0], lengths[1]] {
                    global.extend_from_slice(&word.to_le_bytes());
                }
                global.extend_from_slice(books);
                level.extend_from_slice(color);
                level.extend_from_slice(alpha);
                1
            }
            Texels::Uastc { blocks, zstd } => {
                level = if *zstd { self.unpack(blocks)? } else { blocks.to_vec() };
                0
            }
        };
        let level_at = global_at + global.len();
        let unpacked = if scheme == 1 { 0 } else { level.len() as u64 };
        let mut file = Vec::with_capacity(level_at + level.len());
        file.extend_from_slice(&IDENTIFIER);
        for word in [0, 1, self.width, self.height, 0, 0, 1, 1, scheme] {
            file.extend_from_slice(&word.to_le_bytes());
        }
        for word in [format_at as u32, self.format.len() as u32, 0, 0] {
            file.extend_from_slice(&word.to_le_bytes());
        }
        for long in [global_at as u64, global.len() as u64, level_at as u64, level.len() as u64, unpacked] {
            file.extend_from_slice(&long.to_le_bytes());
        }
        file.extend_from_slice(self.format);
        file.append(&mut global);
        file.append(&mut level);
        Ok(file)
    }

    /// Unpacks a Zstandard frame, which must hold exactly the image's blocks.
    fn unpack(&self, frame: &[u8]) -> Result<Vec<u8>, String> {
        let broken = || "its Zstandard data is broken".to_owned();
        let bytes = usize::try_from(self.uastc_bytes()).map_err(|_| broken())?;
        let mut decoder =
            StreamingDecoder::new_with_max_window_size(frame, self.window()).map_err(|_| broken())?;
        let mut blocks = vec![0; bytes];
        decoder.read_exact(&mut blocks).map_err(|_| broken())?;
        Ok(blocks)
    }

    /// The largest window that a Zstandard frame of the image may have, bytes.
    fn window(&self) -> u64 {
        self.uastc_bytes().max(ZSTD_WINDOW)
    }

    fn uastc_bytes(&self) -> u64 {
        self.blocks() * UASTC_BLOCK
    }

    fn blocks(&self) -> u64 {
        u64::from(self.width.div_ceil(4)) * u64::from(self.height.div_ceil(4))
    }
}

/// Finds the parts of ETC1S data: `global` holds the codebooks' header, an image description per level, and
/// the codebooks; `level` is the data of the first level.
fn etc1s<'a>(global: &'a [u8], level: &'a [u8], levels: u32, has_alpha: bool) -> Option<Texels<'a>> {
    let (header, rest) = global.split_at_checked(CODEBOOK_PART)?;
    let books_at = usize::try_from(levels).ok()?.checked_mul(CODEBOOK_PART)?;
    let (images, books) = rest.split_at_checked(books_at)?;
    let image = images.first_chunk::<CODEBOOK_PART>()?;
    let slice = |at: usize| {
        let from = word(image, at) as usize;
        level.get(from..from.checked_add(word(image, at + 4) as usize)?)
    };
    let alpha = if has_alpha { slice(12)? } else { &[] };
    let lengths = [4, 8, 12].map(|at| u64::from(word(header, at)));
    let fits = lengths.iter().sum::<u64>() <= books.len() as u64;
    fits.then_some(Texels::Etc1s { header, books, slices: [slice(4)?, alpha] })
}

/// A little-endian 32-bit number; 0 past the end of the bytes.
fn word(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..).and_then(<[u8]>::first_chunk).copied().map_or(0, u32::from_le_bytes)
}

/// A little-endian 64-bit number; 0 past the end of the bytes.
fn long(bytes: &[u8], at: usize) -> u64 {
    bytes.get(at..).and_then(<[u8]>::first_chunk).copied().map_or(0, u64::from_le_bytes)
}

fn byte(bytes: &[u8], at: usize) -> u8 {
    bytes.get(at).copied().unwrap_or_default()
}

/// The name of a common Vulkan format, in brackets.
fn vulkan_name(format: u32) -> &'static str {
    match format {
        9 => " (R8_UNORM)",
        16 => " (R8G8_UNORM)",
        23 => " (R8G8B8_UNORM)",
        29 => " (R8G8B8_SRGB)",
        37 => " (R8G8B8A8_UNORM)",
        43 => " (R8G8B8A8_SRGB)",
        97 => " (R16G16B16A16_SFLOAT)",
        131..=146 => " (a BC format)",
        147..=156 => " (an ETC2 or EAC format)",
        157..=184 => " (an ASTC format)",
        _ => "",
    }
}

/// The name of a colour model of the Khronos Data Format, in brackets.
fn model_name(model: u8) -> &'static str {
    match model {
        1 => " (RGBSDA)",
        162 => " (ASTC)",
        167 | 168 => " (UASTC HDR)",
        169 => " (XUASTC LDR)",
        _ => "",
    }
}
