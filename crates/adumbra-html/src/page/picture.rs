//! Pictures embedded in a page.

use adumbra_program::exit::Failure;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::codecs::webp::WebPEncoder;
use image::imageops;
use image::{ExtendedColorType, ImageEncoder, RgbImage};

/// The encoding of an embedded picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureEncoding {
    /// Lossless: WebP or PNG, whichever is smaller.
    Lossless,
    /// JPEG of this quality, 1 to 100.
    Lossy(u8),
}

/// A picture encoded as a data URI.
#[derive(Clone, Debug, PartialEq)]
pub struct Embedded {
    /// `data:image/...;base64,...`
    pub uri: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
}

impl Embedded {
    /// Encodes a PNG, or its `part` `[x, y, width, height]` in pixels, clipped to the picture. Pictures wider
    /// than `widest` pixels are scaled down to that width.
    ///
    /// Cost: tens of milliseconds per megapixel.
    ///
    /// # Errors
    /// Returns [`Failure::BadInput`] if the bytes are not a picture, or if it cannot be encoded.
    pub fn from_png(
        bytes: &[u8],
        part: Option<[u32; 4]>,
        widest: u32,
        encoding: PictureEncoding,
    ) -> Result<Self, Failure> {
        let image =
            image::load_from_memory(bytes).map_err(|e| Failure::BadInput(format!("not a picture: {e}")))?;
        let mut image = image.into_rgb8();
        if let Some([x, y, width, height]) = part {
            image = imageops::crop_imm(&image, x, y, width, height).to_image();
        }
        if image.width() > widest {
            let height = (f64::from(image.height()) * f64::from(widest) / f64::from(image.width())).round();
            image = imageops::resize(&image, widest, (height as u32).max(1), imageops::FilterType::Triangle);
        }
        let (kind, bytes) = encode(&image, encoding).map_err(|e| {
            let [width, height] = [image.width(), image.height()];
            Failure::BadInput(format!("cannot encode a picture of {width} x {height} pixels: {e}"))
        })?;
        Ok(Self {
            uri: format!("data:image/{kind};base64,{}", STANDARD.encode(bytes)),
            width: image.width(),
            height: image.height(),
        })
    }
}

fn encode(image: &RgbImage, encoding: PictureEncoding) -> image::ImageResult<(&'static str, Vec<u8>)> {
    let (width, height) = image.dimensions();
    if let PictureEncoding::Lossy(quality) = encoding {
        let mut jpeg = Vec::new();
        JpegEncoder::new_with_quality(&mut jpeg, quality).write_image(
            image,
            width,
            height,
            ExtendedColorType::Rgb8,
        )?;
        return Ok(("jpeg", jpeg));
    }
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Default, FilterType::Adaptive).write_image(
        image,
        width,
        height,
        ExtendedColorType::Rgb8,
    )?;
    let mut webp = Vec::new();
    WebPEncoder::new_lossless(&mut webp).write_image(image, width, height, ExtendedColorType::Rgb8)?;
    Ok(if webp.len() < png.len() { ("webp", webp) } else { ("png", png) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> Vec<u8> {
        let rgb: Vec<u8> = (0..100 * 50_u32).flat_map(|i| [(i % 100) as u8, (i / 100) as u8, 7]).collect();
        let mut png = Vec::new();
        PngEncoder::new(&mut png).write_image(&rgb, 100, 50, ExtendedColorType::Rgb8).unwrap();
        png
    }

    #[test]
    fn embedded_picture_is_lossless_or_scaled_or_cropped() {
        let whole = Embedded::from_png(&gradient(), None, 100, PictureEncoding::Lossless).unwrap();
        assert_eq!((whole.width, whole.height), (100, 50));
        let bytes = STANDARD.decode(whole.uri.split_once(',').unwrap().1).unwrap();
        let again = image::load_from_memory(&bytes).unwrap().into_rgb8();
        assert_eq!(again.get_pixel(99, 49).0, [99, 49, 7]);
        let small = Embedded::from_png(&gradient(), None, 40, PictureEncoding::Lossy(80)).unwrap();
        assert_eq!((small.width, small.height), (40, 20));
        assert!(small.uri.starts_with("data:image/jpeg;base64,"));
        let part =
            Embedded::from_png(&gradient(), Some([90, 10, 30, 20]), 100, PictureEncoding::Lossless).unwrap();
        assert_eq!((part.width, part.height), (10, 20));
    }

    #[test]
    fn embedded_picture_rejects_non_pictures() {
        assert!(matches!(
            Embedded::from_png(b"not a png", None, 9, PictureEncoding::Lossless),
            Err(Failure::BadInput(what)) if what.starts_with("not a picture")
        ));
    }
}
