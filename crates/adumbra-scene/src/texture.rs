//! Textures as shadows need them: images and sampled alpha. Colours are sampled by [`crate::MippedTexture`].
//!
//! Coordinates follow glTF 2.0: (0, 0) is the top left corner, and texel centres are at half-integers.
//! Sampling uses only plain 32-bit float arithmetic, so every machine gets the same value. There are no mip
//! levels: alpha cut-offs are tested on the full-resolution texture.

use std::io::Cursor;

use image::{ColorType, DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use crate::budget::Budget;
use crate::error::Result;
use crate::ktx2;

/// An image with its wrap and filter modes.
#[derive(Clone, Debug)]
pub struct Texture {
    /// The image's name or file, or a generated name.
    pub name: String,
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// The texels, row by row from the top.
    pub pixels: Pixels,
    /// Wrap modes for u and v, applied outside 0…1.
    pub wrap: [Wrap; 2],
    /// Whether to sample the nearest texel instead of filtering bilinearly.
    pub nearest: bool,
}

/// Texel storage. The alpha-only form is a quarter of the size and is enough for opacity.
#[derive(Clone, Debug)]
pub enum Pixels {
    /// One byte per texel: alpha. The colour reads as white.
    Alpha(Vec<u8>),
    /// Four bytes per texel: sRGB red, green, blue, then linear alpha.
    Rgba(Vec<u8>),
}

/// How a texture continues outside 0…1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// Repeats.
    #[default]
    Repeat,
    /// Repeats, mirrored every second time.
    Mirror,
    /// Repeats the edge texels.
    Clamp,
}

/// Memory allowed for a PNG's colour profile and one row, in addition to a few times its file length, bytes.
const PNG_HEADER_BYTES: u64 = 16 << 20;

/// The layout and sampling modes of a texel grid.
pub(super) struct Grid {
    /// Texels along u and v.
    pub(super) size: [u32; 2],
    pub(super) wrap: [Wrap; 2],
    pub(super) nearest: bool,
}

/// One axis of a bilinear sample: two texel indices and the weight of the second.
#[derive(Clone, Copy)]
struct Axis {
    low: u32,
    high: u32,
    weight: f32,
}

impl Texture {
    /// Alpha at `uv`, 0…1. A non-finite coordinate counts as 0. Cost: four texel reads, or one for a nearest
    /// texture.
    #[inline]
    pub fn alpha(&self, uv: [f32; 2]) -> f32 {
        self.sample(uv, |texel| [self.alpha_byte(texel)])[0] / 255.0
    }

    /// Bytes held by the texels.
    pub(super) fn memory_bytes(&self) -> usize {
        match &self.pixels {
            Pixels::Alpha(bytes) | Pixels::Rgba(bytes) => bytes.capacity(),
        }
    }

    /// Whether every texel has full alpha, so that the texture cannot cut anything out.
    pub(crate) fn is_fully_opaque(&self) -> bool {
        match &self.pixels {
            Pixels::Alpha(bytes) => bytes.iter().all(|&a| a == 255),
            Pixels::Rgba(bytes) => bytes.chunks_exact(4).all(|texel| texel[3] == 255),
        }
    }

    /// Decodes a PNG, JPEG, WebP, TGA, BMP or KTX2 file. The texture repeats and is filtered bilinearly.
    /// `ending` gives the format if the bytes do not identify it. With `alpha_only` the colours are dropped.
    /// The inner error is a clause for [`crate::Error::Texture`].
    ///
    /// # Errors
    /// Returns [`crate::Error::SceneMemory`] if the image size stated in its header exceeds the budget.
    pub(super) fn decode(
        name: String,
        bytes: &[u8],
        ending: &str,
        alpha_only: bool,
        budget: &Budget<'_>,
    ) -> Result<Result<Self, String>> {
        if ktx2::is_ktx2(bytes) {
            return Self::decode_ktx2(name, bytes, alpha_only, budget);
        }
        let (format, decoder) = match open(bytes, ending) {
            Ok(opened) => opened,
            Err(what) => return Ok(Err(what)),
        };
        let ((width, height), color) = (decoder.dimensions(), decoder.color_type());
        let texels = u64::from(width) * u64::from(height);
        let kept = if alpha_only { texels } else { 4 * texels };
        // The decoded image, its converted copy if one is needed, and the part that is kept.
        let converted =
            if color == ColorType::Rgba8 || alpha_only && color == ColorType::La8 { 0 } else { 4 };
        let peak = decoder.total_bytes() + converted * texels + if alpha_only { texels } else { 0 };
        let peak = peak.max(kept);
        budget.charge(peak, || format!("the texture {name:?} of {width} x {height} texels"))?;
        budget.charge_decoding(decoder.total_bytes(), || {
            format!("all textures up to {name:?} of {width} x {height} texels, decoded one by one")
        })?;
        let result = DynamicImage::from_decoder(decoder).map_err(|e| fault(format, &e)).and_then(|image| {
            if texels == 0 {
                return Err("the image is empty".to_owned());
            }
            let pixels = match image {
                image if !alpha_only => Pixels::Rgba(image.into_rgba8().into_raw()),
                DynamicImage::ImageLumaA8(image) => Pixels::Alpha(image.pixels().map(|p| p.0[1]).collect()),
                image if image.color().has_alpha() => {
                    Pixels::Alpha(image.into_rgba8().pixels().map(|p| p.0[3]).collect())
                }
                _ => Pixels::Alpha(vec![255; width as usize * height as usize]),
            };
            Ok(Self { name, width, height, pixels, wrap: [Wrap::Repeat; 2], nearest: false })
        });
        budget.release(if result.is_ok() { peak - kept } else { peak });
        Ok(result)
    }

    #[cfg(feature = "ktx2")]
    fn decode_ktx2(
        name: String,
        bytes: &[u8],
        alpha_only: bool,
        budget: &Budget<'_>,
    ) -> Result<Result<Self, String>> {
        let image = match ktx2::Image::open(bytes) {
            Ok(image) => image,
            Err(what) => return Ok(Err(what)),
        };
        let (width, height) = (image.width, image.height);
        let texels = u64::from(width) * u64::from(height);
        if let Err(what) = check_size(width, height, 4 * texels) {
            return Ok(Err(what));
        }
        let kept = if alpha_only { texels } else { 4 * texels };
        let peak = image.peak_bytes() + if alpha_only { texels } else { 0 };
        budget.charge(peak, || format!("the texture {name:?} of {width} x {height} texels"))?;
        budget.charge_decoding(peak, || {
            format!("all textures up to {name:?} of {width} x {height} texels, decoded one by one")
        })?;
        let result = image.rgba().map(|rgba| {
            let pixels = match alpha_only {
                true => Pixels::Alpha(rgba.chunks_exact(4).map(|texel| texel[3]).collect()),
                false => Pixels::Rgba(rgba),
            };
            Self { name, width, height, pixels, wrap: [Wrap::Repeat; 2], nearest: false }
        });
        budget.release(if result.is_ok() { peak - kept } else { peak });
        Ok(result)
    }

    #[cfg(not(feature = "ktx2"))]
    fn decode_ktx2(_: String, _: &[u8], _: bool, _: &Budget<'_>) -> Result<Result<Self, String>> {
        Ok(Err("it is a KTX2 file, and this program was built without the feature ktx2 that decodes it"
            .to_owned()))
    }

    #[inline]
    fn alpha_byte(&self, texel: usize) -> f32 {
        let byte = match &self.pixels {
            Pixels::Alpha(bytes) => bytes.get(texel),
            Pixels::Rgba(bytes) => bytes.get(texel * 4 + 3),
        };
        f32::from(byte.copied().unwrap_or(255))
    }

    #[inline]
    fn sample<const N: usize>(&self, uv: [f32; 2], fetch: impl Fn(usize) -> [f32; N]) -> [f32; N] {
        Grid { size: [self.width, self.height], wrap: self.wrap, nearest: self.nearest }.sample(uv, fetch)
    }
}

impl Grid {
    /// Samples the nearest texel at `uv`, or blends four. `fetch` takes a texel index.
    #[inline]
    pub(super) fn sample<const N: usize>(&self, uv: [f32; 2], fetch: impl Fn(usize) -> [f32; N]) -> [f32; N] {
        let Self { size: [width, height], wrap, nearest } = *self;
        let index = |x: u32, y: u32| y as usize * width as usize + x as usize;
        if nearest {
            return fetch(index(nearest_texel(uv[0], width, wrap[0]), nearest_texel(uv[1], height, wrap[1])));
        }
        let x = axis(uv[0], width, wrap[0]);
        let y = axis(uv[1], height, wrap[1]);
        let mix = |a: [f32; N], b: [f32; N], w: f32| std::array::from_fn(|c| a[c] + (b[c] - a[c]) * w);
        let top = mix(fetch(index(x.low, y.low)), fetch(index(x.high, y.low)), x.weight);
        let bottom = mix(fetch(index(x.low, y.high)), fetch(index(x.high, y.high)), x.weight);
        mix(top, bottom, y.weight)
    }
}

/// Reads an image's header. The error is a clause for a message.
fn open<'a>(bytes: &'a [u8], ending: &str) -> Result<(ImageFormat, impl ImageDecoder + 'a), String> {
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
    if reader.format().is_none()
        && let Some(format) = ImageFormat::from_extension(ending)
    {
        reader.set_format(format);
    }
    let Some(format) = reader.format() else {
        return Err("it is not a PNG, JPEG, WebP, TGA, BMP or KTX2 image".to_owned());
    };
    if format == ImageFormat::Png {
        // The decoder unpacks the colour profile before it reports the image size. A larger profile is
        // skipped. Text chunks may be held in memory a few times over.
        let mut limits = Limits::default();
        limits.max_alloc = Some(PNG_HEADER_BYTES.saturating_add(bytes.len() as u64 * 4));
        reader.limits(limits);
    }
    let decoder = reader.into_decoder().map_err(|e| fault(format, &e))?;
    // Enforces the image library's size limit for a single image.
    let (width, height) = decoder.dimensions();
    check_size(width, height, decoder.total_bytes())?;
    Ok((format, decoder))
}

/// Says in plain words why an image cannot be decoded: a clause for a message.
fn fault(format: ImageFormat, error: &ImageError) -> String {
    let name = match format {
        ImageFormat::Png => "PNG",
        ImageFormat::Jpeg => "JPEG",
        ImageFormat::WebP => "WebP",
        ImageFormat::Tga => "TGA",
        ImageFormat::Bmp => "BMP",
        _ => return "it is not a PNG, JPEG, WebP, TGA, BMP or KTX2 image".to_owned(),
    };
    match error {
        ImageError::Limits(_) => "it is larger than an image may be".to_owned(),
        ImageError::Unsupported(_) => format!("it is a kind of {name} image that cannot be read"),
        ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => {
            format!("its {name} data ends too early")
        }
        _ => format!("it is damaged, or no {name} image"),
    }
}

/// Refuses an image that decodes to more bytes than a single image may have. The error is a clause for a
/// message.
fn check_size(width: u32, height: u32, bytes: u64) -> Result<(), String> {
    Limits::default()
        .reserve(bytes)
        .map_err(|_| format!("its {width} x {height} texels are more than an image may have"))
}

/// Rounds down; avoids the library call for numbers of ordinary size.
#[inline]
fn floor(u: f32) -> f32 {
    if u.abs() >= 1e6 {
        return u.floor();
    }
    let towards_zero = u as i32 as f32;
    if towards_zero > u { towards_zero - 1.0 } else { towards_zero }
}

/// Maps a coordinate into 0…1.
#[inline]
fn wrapped(u: f32, wrap: Wrap) -> f32 {
    if !u.is_finite() {
        return 0.0;
    }
    match wrap {
        Wrap::Repeat => u - floor(u),
        Wrap::Mirror => {
            let m = u - 2.0 * floor(u * 0.5);
            if m > 1.0 { 2.0 - m } else { m }
        }
        Wrap::Clamp => u.clamp(0.0, 1.0),
    }
}

#[inline]
fn nearest_texel(u: f32, size: u32, wrap: Wrap) -> u32 {
    ((wrapped(u, wrap) * size as f32) as u32).min(size.saturating_sub(1))
}

#[inline]
fn axis(u: f32, size: u32, wrap: Wrap) -> Axis {
    let t = wrapped(u, wrap) * size as f32 - 0.5;
    let low = floor(t);
    let last = i64::from(size) - 1;
    let inside = |i: i64| match wrap {
        Wrap::Repeat if i < 0 => last,
        Wrap::Repeat if i > last => 0,
        _ => i.clamp(0, last.max(0)),
    };
    Axis { low: inside(low as i64) as u32, high: inside(low as i64 + 1) as u32, weight: t - low }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skips_large_colour_profiles() {
        use image::ImageEncoder;
        let with_profile = |bytes: usize| {
            let mut out = Vec::new();
            let mut encoder = image::codecs::png::PngEncoder::new(&mut out);
            encoder.set_icc_profile(vec![0; bytes]).expect("PNG has profiles");
            encoder.write_image(&[0; 4], 2, 2, image::ExtendedColorType::L8).expect("encodes");
            out
        };
        for (stated, found) in [(4096, Some(4096)), (64 << 20, None)] {
            let bytes = with_profile(stated);
            let (_, mut decoder) = open(&bytes, "").expect("opens");
            assert_eq!(decoder.icc_profile().expect("opens").map(|p| p.len()), found);
            DynamicImage::from_decoder(decoder).expect("decodes");
        }
    }

    fn two_by_two(wrap: Wrap, nearest: bool) -> Texture {
        let pixels = Pixels::Alpha(vec![0, 255, 255, 255]);
        Texture { name: "t".into(), width: 2, height: 2, pixels, wrap: [wrap; 2], nearest }
    }

    #[test]
    fn texture_origin_is_top_left_and_centres_are_at_half() {
        let t = two_by_two(Wrap::Clamp, false);
        assert_eq!(t.alpha([0.25, 0.25]), 0.0);
        assert_eq!(t.alpha([0.75, 0.25]), 1.0);
        assert_eq!(t.alpha([0.5, 0.25]), 0.5);
        assert_eq!(t.alpha([0.0, 0.0]), 0.0);
    }

    #[test]
    fn texture_wraps() {
        let repeat = two_by_two(Wrap::Repeat, false);
        assert_eq!(repeat.alpha([1.25, -0.75]), 0.0);
        assert_eq!(repeat.alpha([0.0, 0.25]), 0.5);
        let mirror = two_by_two(Wrap::Mirror, false);
        assert_eq!(mirror.alpha([-0.25, 2.25]), 0.0);
        assert_eq!(mirror.alpha([1.25, 0.25]), 1.0);
        let clamp = two_by_two(Wrap::Clamp, true);
        assert_eq!(clamp.alpha([-9.0, 0.1]), 0.0);
        assert_eq!(clamp.alpha([9.0, 0.1]), 1.0);
    }

    #[test]
    fn alpha_is_valid_at_any_coordinate() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for nearest in [false, true] {
                let t = two_by_two(wrap, nearest);
                for u in [f32::NAN, f32::INFINITY, -f32::INFINITY, f32::MAX, f32::MIN, -1e-12, 1e-40, 1.0] {
                    for v in [0.3, u] {
                        assert!((0.0..=1.0).contains(&t.alpha([u, v])));
                    }
                }
            }
        }
    }
}
