//! The look-up texture, version 3: a file's words and its parameter block in rows of texels.
//! `spec/look-up-texture.md` describes it.
//!
//! A texel is one little-endian word. With the format `R32Uint` it is the word itself, with `Rgba8Unorm` its
//! bytes from the lowest (R) to the highest (A). Word w is in column `w % width` and row `w / width`, and the
//! width is a power of two. The first [`HEADER_WORDS`] words are the header. The file's words follow.
//!
//! | words | meaning |
//! |---|---|
//! | 0 | [`TEXTURE_MAGIC`] |
//! | 1 | [`TEXTURE_VERSION`] |
//! | 2 | layout: 2, the quadtree |
//! | 3 | number of words after the header |
//! | 4 to 6 | the anchor: world position that look-ups are relative to, `f32` |
//! | 7 | number of coarser levels whose headers follow; zero for a whole file |
//! | 8 to 10 | unit vector towards the sun, `f32` |
//! | 11 to 15 | zero |
//! | 16 to 103 | the parameter block, [`Parameters`] |
//! | 104 to 127 | zero |

use super::parameters::{LookUp, Parameters, WordPlaces};
use super::wgsl::{Bindings, TexelFormat, of_texture};
use super::words::Words;
use crate::error::{RangeError, RangeField, Result};
use crate::file::ShadowFile;
use crate::grid::LightGrid;
use crate::settings::Bias;

/// First word of a look-up texture: "ADUT" as bytes.
pub const TEXTURE_MAGIC: u32 = u32::from_le_bytes(*b"ADUT");
/// Version of the look-up texture that is written.
pub const TEXTURE_VERSION: u32 = 3;
/// Number of words of a look-up texture's header, which precede the file's words.
pub const HEADER_WORDS: usize = 128;

/// The header's layout: a quadtree of switch depths.
const QUADTREE: u32 = 2;
/// Index of the first word of the parameter block.
const PARAMETERS_AT: usize = 16;
/// Width of the narrowest texture. Its first row is the header.
const MIN_WIDTH: u32 = HEADER_WORDS as u32;

/// A file as a texture, with the parameters of look-ups in its header.
///
/// Positions in the shader are relative to [`LookUpTexture::anchor_world`], the middle of the file's grid, so
/// nothing has to be uploaded per frame. For another look-up, only the header's bytes change. An engine that
/// shows one file in several ways keeps one texture, and a header for each way from
/// [`FileForGpu::texture_header`](super::FileForGpu::texture_header).
#[derive(Clone, Debug)]
pub struct LookUpTexture {
    width: u32,
    height: u32,
    bytes: Vec<u8>,
    /// The file's grid, bias and places of words.
    grid: LightGrid,
    bias: Bias,
    words: WordPlaces,
    parameters: Parameters,
    anchor_world: [f32; 3],
}

impl LookUpTexture {
    /// Creates a texture of at most `max_side` texels along each side. It is as square as a power-of-two
    /// width allows. Devices support at least 4096 texels, most of them 8192 or 16384. Cost: one copy of the
    /// file's words.
    ///
    /// # Errors
    /// Returns [`Error::Range`](crate::Error::Range) if the file needs more texels, and the errors of
    /// [`Parameters::new`].
    pub fn new(file: &ShadowFile, look_up: &LookUp, max_side: u32) -> Result<Self> {
        let (grid, bias, places) = (file.grid, file.settings.bias, WordPlaces::of(file));
        let (parameters, anchor_world) = placed_parameters(&grid, bias, places, look_up)?;
        let words = Words::new(&file.tree);
        let texels = HEADER_WORDS as u64 + words.count();
        let Some((width, height)) = size(texels, max_side) else {
            let range = "at most the square of the largest side in texels; bake at a lower resolution";
            return Err(RangeError::new(RangeField::TextureWords, words.count(), range).into());
        };
        let mut bytes = Vec::with_capacity(4 * width as usize * height as usize);
        // The number of words of a texture fits 32 bits.
        let placed = grid.placed(&look_up.placement);
        put_header(&mut bytes, &parameters, anchor_world, &placed, words.count() as u32);
        words.iter().for_each(|word| bytes.extend(word.to_le_bytes()));
        bytes.resize(4 * width as usize * height as usize, 0);
        Ok(Self { width, height, bytes, grid, bias, words: places, parameters, anchor_world })
    }

    /// Returns the number of texels per row, a power of two.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns all texels, rows in order, four bytes each. This is the upload for either format.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns the header's bytes, the first texels of the texture. This is the upload after
    /// [`LookUpTexture::set_look_up`].
    pub fn header(&self) -> &[u8] {
        &self.bytes[..4 * HEADER_WORDS]
    }

    /// Returns the WGSL of look-ups in the texture at the first binding. It defines the functions of
    /// [`FileForGpu::wgsl`](super::FileForGpu::wgsl). Positions are relative to `adumbra_texture_anchor()`,
    /// and `adumbra_texture_towards_sun()` is the unit vector towards the sun. Each call fetches 73 texels of
    /// parameters, the same for every pixel.
    pub fn wgsl(&self, format: TexelFormat, bindings: Bindings) -> String {
        of_texture(format, bindings)
    }

    /// Returns the world position that positions in the shader are relative to. Each coordinate is
    /// representable as `f32`, so that engines can subtract it exactly.
    pub fn anchor_world(&self) -> [f32; 3] {
        self.anchor_world
    }

    /// Returns the parameters of look-ups.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Changes the look-up. Only the header changes, and the anchor if the placement does. After an error,
    /// nothing has changed.
    ///
    /// # Errors
    /// Returns the errors of [`Parameters::new`].
    pub fn set_look_up(&mut self, look_up: &LookUp) -> Result<()> {
        (self.parameters, self.anchor_world) = placed_parameters(&self.grid, self.bias, self.words, look_up)?;
        let count = u32::from_le_bytes(std::array::from_fn(|i| self.bytes[12 + i]));
        let mut header = Vec::with_capacity(4 * HEADER_WORDS);
        let placed = self.grid.placed(&look_up.placement);
        put_header(&mut header, &self.parameters, self.anchor_world, &placed, count);
        self.bytes[..header.len()].copy_from_slice(&header);
        Ok(())
    }
}

/// Returns the parameters of a look-up relative to the middle of the placed grid, and that middle.
fn placed_parameters(
    grid: &LightGrid,
    bias: Bias,
    words: WordPlaces,
    look_up: &LookUp,
) -> Result<(Parameters, [f32; 3])> {
    let anchor_world = middle(&grid.placed(&look_up.placement));
    let parameters = Parameters::of_grid(grid, bias, words, look_up, anchor_world.map(f64::from))?;
    Ok((parameters, anchor_world))
}

/// Returns the middle of a grid, rounded to `f32`.
pub(crate) fn middle(grid: &LightGrid) -> [f32; 3] {
    grid.to_world(grid.size.map(|n| 0.5 * f64::from(n))).map(|c| c as f32)
}

/// Adds the header of a texture, or of one of its levels. `words` is the number of words after the first
/// header.
pub(crate) fn put_header(
    out: &mut Vec<u8>,
    parameters: &Parameters,
    anchor_world: [f32; 3],
    grid: &LightGrid,
    words: u32,
) {
    let mut header = [0; HEADER_WORDS];
    header[..4].copy_from_slice(&[TEXTURE_MAGIC, TEXTURE_VERSION, QUADTREE, words]);
    header[4..7].copy_from_slice(&anchor_world.map(f32::to_bits));
    header[7] = parameters.coarser_levels;
    header[8..11].copy_from_slice(&grid.sun.towards().map(|c| (c as f32).to_bits()));
    let start = out.len();
    out.extend(header.into_iter().flat_map(u32::to_le_bytes));
    out[start + 4 * PARAMETERS_AT..][..Parameters::BYTES].copy_from_slice(&parameters.to_bytes());
}

/// Returns width and height of the texture with the least area, and among equals the widest, whose width is a
/// power of two. `None` if a side would be longer than `max_side`.
fn size(texels: u64, max_side: u32) -> Option<(u32, u32)> {
    let mut width = u64::from(MIN_WIDTH);
    while width * width < texels {
        width *= 2;
    }
    let height = texels.div_ceil(width);
    let fits = width <= max_side.into() && height <= max_side.into();
    // If the square is too wide, half the width with twice the rows may fit. Otherwise nothing does.
    let (width, height) = if fits { (width, height) } else { (width / 2, texels.div_ceil(width / 2)) };
    let fits = width >= MIN_WIDTH.into() && width <= max_side.into() && height <= max_side.into();
    fits.then_some((width as u32, height as u32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_is_as_square_as_powers_of_two_allow() {
        assert_eq!(size(129, 4096), Some((128, 2)));
        assert_eq!(size(128 * 128 + 1, 4096), Some((256, 65)));
        assert_eq!(size(1 << 24, 4096), Some((4096, 4096)));
        assert_eq!(size((1 << 24) + 1, 4096), None);
        // A `max_side` that is not a power of two is used in full by the rows.
        assert_eq!(size(4000 * 2048, 4000), Some((2048, 4000)));
        assert_eq!(size(4000 * 2048 + 1, 4000), None);
        assert_eq!(size(129, 100), None);
    }
}
