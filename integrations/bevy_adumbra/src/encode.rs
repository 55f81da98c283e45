//! Encodes bytes of words in the formats of textures that Bevy draws into.

use std::borrow::Cow;

use bevy::render::render_resource::TextureFormat;

/// Returns the bytes of words in a format, or `None` for a format that cannot hold them.
pub(crate) fn encoded(bytes: &[u8], format: TextureFormat) -> Option<Cow<'_, [u8]>> {
    Some(match format {
        TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb => bytes.into(),
        TextureFormat::Bgra8Unorm | TextureFormat::Bgra8UnormSrgb => {
            bytes.chunks(4).flat_map(|texel| [texel[2], texel[1], texel[0], texel[3]]).collect()
        }
        TextureFormat::Rgba16Float => bytes.iter().flat_map(|&b| half(b).to_le_bytes()).collect(),
        TextureFormat::Rgba32Float => bytes.iter().flat_map(|&b| f32::from(b).to_le_bytes()).collect(),
        _ => return None,
    })
}

/// Returns a number as a half float.
///
/// Worked value: 5 is 1.25 · 2^2, so its exponent is 15 + 2 and its fraction a quarter of 2^10: 0x4500.
fn half(number: u8) -> u16 {
    let Some(exponent) = number.checked_ilog2() else { return 0 };
    let exponent = exponent as u16;
    (exponent + 15) << 10 | (u16::from(number) << (10 - exponent)) & 0x3ff
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_encodes_bytes_exactly() {
        assert_eq!([0, 1, 2, 5, 255].map(half), [0, 0x3c00, 0x4000, 0x4500, 0x5bf8]);
    }

    #[test]
    fn encodes_bytes_for_each_texture_format() {
        let bytes = [1, 2, 3, 255];
        assert_eq!(encoded(&bytes, TextureFormat::Rgba8UnormSrgb), Some(bytes[..].into()));
        assert_eq!(encoded(&bytes, TextureFormat::Bgra8Unorm), Some(vec![3, 2, 1, 255].into()));
        assert_eq!(encoded(&bytes, TextureFormat::Rgba16Float).map(|b| b.len()), Some(8));
        assert_eq!(encoded(&bytes, TextureFormat::R8Unorm), None);
    }
}
