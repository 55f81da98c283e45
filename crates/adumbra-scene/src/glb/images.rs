//! Textures of a GLB file: images as PNG (W3C, *Portable Network Graphics*, third edition) in buffer views,
//! and samplers. Texture n of the scene is texture, image and sampler n of the file.

use png::{BitDepth, ColorType, DeflateCompression, Encoder, Filter};
use serde::Serialize;

use super::GltfJson;
use crate::{Pixels, Scene, Texture, Wrap};

const NEAREST: u32 = 9728;
const LINEAR: u32 = 9729;
const CLAMP_TO_EDGE: u32 = 33071;
const MIRRORED_REPEAT: u32 = 33648;
const REPEAT: u32 = 10497;

/// Appends the scene's textures to the file.
pub(super) fn push_textures<'a>(scene: &'a Scene, document: &mut GltfJson<'a>, bin: &mut Vec<u8>) {
    for (n, texture) in scene.textures.iter().enumerate() {
        let start = bin.len();
        // Writing to memory does not fail, and `pixels_of` gives as many bytes as the size requires.
        bin.extend(png_of(texture).unwrap_or_default());
        let buffer_view = document.view(start, bin, None);
        document.images.push(ImageJson { name: &texture.name, buffer_view, mime_type: "image/png" });
        let filter = if texture.nearest { NEAREST } else { LINEAR };
        let [wrap_s, wrap_t] = texture.wrap.map(|wrap| match wrap {
            Wrap::Repeat => REPEAT,
            Wrap::Mirror => MIRRORED_REPEAT,
            Wrap::Clamp => CLAMP_TO_EDGE,
        });
        document.samplers.push(SamplerJson { mag_filter: filter, wrap_s, wrap_t });
        document.textures.push(TextureJson { sampler: n, source: n });
    }
}

/// Encodes a texture's texels. They are stored uncompressed, so that the bytes do not depend on a
/// compressor's version.
fn png_of(texture: &Texture) -> Result<Vec<u8>, png::EncodingError> {
    let (color, pixels) = pixels_of(texture);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, texture.width, texture.height);
    encoder.set_color(color);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_filter(Filter::NoFilter);
    encoder.set_deflate_compression(DeflateCompression::NoCompression);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels)?;
    writer.finish()?;
    Ok(bytes)
}

/// Returns the texels as PNG stores them. Missing texels are white and opaque, as in sampling.
fn pixels_of(texture: &Texture) -> (ColorType, Vec<u8>) {
    let texels = texture.width as usize * texture.height as usize;
    let (color, channels, mut bytes) = match &texture.pixels {
        Pixels::Alpha(alphas) => {
            (ColorType::GrayscaleAlpha, 2, alphas.iter().flat_map(|&alpha| [u8::MAX, alpha]).collect())
        }
        Pixels::Rgba(bytes) => (ColorType::Rgba, 4, bytes.clone()),
    };
    bytes.resize(texels * channels, u8::MAX);
    (color, bytes)
}

#[derive(Serialize)]
pub(super) struct TextureJson {
    sampler: usize,
    source: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ImageJson<'a> {
    name: &'a str,
    buffer_view: usize,
    mime_type: &'static str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SamplerJson {
    mag_filter: u32,
    wrap_s: u32,
    wrap_t: u32,
}
