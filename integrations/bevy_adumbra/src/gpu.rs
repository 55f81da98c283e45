//! The files in use as one texture, at the binding of a view that Bevy keeps for transmission.
//!
//! Bevy's view bind group has no place for a plugin. Binding 24 is in every view's layout, and Bevy puts a texture there
//! only where something transmissive is drawn. So a view without that gets the words as they are, in `Rgba8Unorm`. A
//! view with it gets one texture of the format that Bevy needs: the picture's rows above, as Bevy copies them, and the
//! words below. Transmission divides by the texture's own size, so it looks up the same texels as before.

use std::sync::Arc;

use bevy::ecs::prelude::*;
use bevy::image::TextureFormatPixelInfo;
use bevy::log::warn_once;
use bevy::math::UVec2;
use bevy::pbr::{Transmissive3d, ViewTransmissionTexture};
use bevy::platform::collections::HashMap;
use bevy::render::Extract;
use bevy::render::camera::ExtractedCamera;
use bevy::render::render_phase::ViewSortedRenderPhases;
use bevy::render::render_resource::{
    Extent3d, FilterMode, Origin3d, Sampler, SamplerDescriptor, TexelCopyBufferLayout, TexelCopyTextureInfo,
    Texture, TextureAspect, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::view::ExtractedView;

use crate::DeviceLimits;
use crate::lights::{FileInUse, FilesInUse};

/// First word of the directory, `ADUD`.
const DIRECTORY_MAGIC: u32 = u32::from_le_bytes(*b"ADUD");
/// First word of the directory that describes a file, and number of words per file.
const FILE_WORDS: [usize; 2] = [8, 8];

/// The files in use, in the render world.
#[derive(Resource, Default)]
pub(crate) struct ExtractedFiles {
    files: Vec<FileInUse>,
    /// Counts changes.
    version: u64,
}

pub(crate) fn extract_files(in_use: Extract<Res<FilesInUse>>, mut extracted: ResMut<ExtractedFiles>) {
    if in_use.is_changed() && extracted.files != in_use.0 {
        extracted.files.clone_from(&in_use.0);
        extracted.version += 1;
    }
}

/// The textures with words, which live as long as files are in use.
#[derive(Resource, Default)]
pub(crate) struct WordTextures {
    version: u64,
    /// The files that the textures hold.
    files: Vec<FileInUse>,
    /// The words alone.
    words: Option<WordTexture>,
    /// Words below a picture, by the picture's size and format.
    below: HashMap<(UVec2, TextureFormat), WordTexture>,
}

impl WordTextures {
    /// Brings the textures up to date. If only settings have changed, less than 1 KiB per file is written.
    fn take(&mut self, device: &RenderDevice, queue: &RenderQueue, version: u64, files: &[FileInUse]) {
        let format = TextureFormat::Rgba8Unorm;
        let has_words = self.files.len() == files.len()
            && self.files.iter().zip(files).all(|(a, b)| Arc::ptr_eq(&a.texture, &b.texture));
        match &self.words {
            Some(words) if has_words => {
                for (row, bytes) in parameters(files) {
                    let size = UVec2::new(bytes.len() as u32 / 4, 1);
                    write(queue, &words.texture, UVec2::new(0, row), size, &bytes);
                    for ((picture, format), below) in &self.below {
                        let Some(bytes) = encoded(&bytes, *format) else { continue };
                        write(queue, &below.texture, UVec2::new(0, picture.y + row), size, &bytes);
                    }
                }
            }
            _ => {
                self.below.clear();
                let has_size = size(&self.files) == size(files);
                let same = self.words.take().filter(|_| has_size);
                let words = same.unwrap_or_else(|| word_texture(device, size(files), format));
                write(queue, &words.texture, UVec2::ZERO, size(files), &rows(files));
                self.words = Some(words);
            }
        }
        self.version = version;
        self.files = files.to_vec();
    }
}

#[derive(Clone)]
struct WordTexture {
    texture: Texture,
    view: TextureView,
    sampler: Sampler,
}

/// On views whose binding has the words.
#[derive(Component)]
pub(crate) struct HasWords;

/// Width and rows of the words of all files and the directory.
fn size(files: &[FileInUse]) -> UVec2 {
    let width = files.iter().map(|file| file.texture.width()).max().unwrap_or(1);
    UVec2::new(width, 1 + files.iter().map(|file| file.texture.height()).sum::<u32>())
}

/// The beginnings of rows that depend on settings: each file's parameters and the directory, with their rows.
fn parameters(files: &[FileInUse]) -> Vec<(u32, Vec<u8>)> {
    let mut directory = vec![0_u32; FILE_WORDS[0] + FILE_WORDS[1] * files.len()];
    directory[..3].copy_from_slice(&[DIRECTORY_MAGIC, files.len() as u32, size(files).y]);
    let (mut row, mut parts) = (0, Vec::new());
    for (n, file) in files.iter().enumerate() {
        let of_file = &mut directory[FILE_WORDS[0] + FILE_WORDS[1] * n..][..4];
        let alone = u32::from(file.is_alone(files));
        of_file.copy_from_slice(&[row, file.texture.width().ilog2(), file.way.code(), alone]);
        parts.push((row, file.header.clone()));
        row += file.texture.height();
    }
    parts.push((row, directory.into_iter().flat_map(u32::to_le_bytes).collect()));
    parts
}

/// Returns the rows of all files and the directory.
fn rows(files: &[FileInUse]) -> Vec<u8> {
    let size = size(files);
    let row_bytes = 4 * size.x as usize;
    let mut bytes = vec![0; row_bytes * size.y as usize];
    let mut row = 0;
    for file in files {
        let rows = file.texture.bytes().chunks(4 * file.texture.width() as usize);
        for (texels, to) in rows.zip(bytes.chunks_mut(row_bytes).skip(row)) {
            to[..texels.len()].copy_from_slice(texels);
        }
        row += file.texture.height() as usize;
    }
    for (row, part) in parameters(files) {
        bytes[row_bytes * row as usize..][..part.len()].copy_from_slice(&part);
    }
    bytes
}

/// Returns the bytes of words in a format that Bevy draws into, or `None` for a format that cannot hold them.
fn encoded(bytes: &[u8], format: TextureFormat) -> Option<Vec<u8>> {
    Some(match format {
        TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb => bytes.to_vec(),
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

/// Gives every 3D view the words of the files in use.
pub(crate) fn give_words(
    mut commands: Commands,
    files: Res<ExtractedFiles>,
    mut textures: ResMut<WordTextures>,
    (device, queue, limits): (Res<RenderDevice>, Res<RenderQueue>, Res<DeviceLimits>),
    transmissive: Res<ViewSortedRenderPhases<Transmissive3d>>,
    views: Query<(Entity, &ExtractedView, &ExtractedCamera, Has<HasWords>)>,
) {
    if files.files.is_empty() {
        if textures.words.is_some() {
            *textures = WordTextures { version: textures.version, ..Default::default() };
        }
        for (entity, view, _, has_words) in &views {
            // Where something is transmissive, Bevy has put its own texture there for this frame.
            if has_words {
                let mut entity = commands.entity(entity);
                entity.remove::<HasWords>();
                if transmissive.get(&view.retained_view_entity).is_none_or(|phase| phase.items.is_empty()) {
                    entity.remove::<ViewTransmissionTexture>();
                }
            }
        }
        return;
    }
    let size = size(&files.files);
    if textures.version != files.version {
        textures.take(&device, &queue, files.version, &files.files);
    }
    let mut used = Vec::new();
    for (entity, view, camera, _) in &views {
        let Some(phase) = transmissive.get(&view.retained_view_entity) else { continue };
        let words = if phase.items.is_empty() {
            textures.words.clone()
        } else {
            let Some(picture) = camera.physical_target_size else { continue };
            let key = (picture, view.target_format);
            used.push(key);
            let known = textures.below.get(&key).cloned();
            known.or_else(|| {
                let words = below_a_picture(&device, &queue, *limits, &files.files, size, key)?;
                textures.below.insert(key, words.clone());
                Some(words)
            })
        };
        let Some(WordTexture { texture, view, sampler }) = words else {
            warn_once!(
                "a view with transmissive materials draws into {:?}, which cannot hold baked shadows; its surfaces are \
                 lit as if nothing baked cast a shadow",
                view.target_format
            );
            continue;
        };
        commands.entity(entity).insert((HasWords, ViewTransmissionTexture { texture, view, sampler }));
    }
    textures.below.retain(|key, _| used.contains(key));
}

/// Returns a texture with a picture's rows above and the words below.
fn below_a_picture(
    device: &RenderDevice,
    queue: &RenderQueue,
    limits: DeviceLimits,
    files: &[FileInUse],
    size: UVec2,
    (picture, format): (UVec2, TextureFormat),
) -> Option<WordTexture> {
    let bytes = encoded(&rows(files), format)?;
    let whole = UVec2::new(picture.x.max(size.x), picture.y + size.y);
    if whole.max_element() > limits.max_texture_side {
        return None;
    }
    let words = word_texture(device, whole, format);
    write(queue, &words.texture, UVec2::new(0, picture.y), size, &bytes);
    Some(words)
}

fn word_texture(device: &RenderDevice, size: UVec2, format: TextureFormat) -> WordTexture {
    let texture = device.create_texture(&TextureDescriptor {
        label: Some("baked shadows"),
        size: extent(size),
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    // As Bevy's own for transmission.
    let sampler = device.create_sampler(&SamplerDescriptor {
        mag_filter: FilterMode::Linear,
        min_filter: FilterMode::Linear,
        ..Default::default()
    });
    WordTexture { texture, view, sampler }
}

fn write(queue: &RenderQueue, texture: &Texture, at: UVec2, size: UVec2, bytes: &[u8]) {
    let to = TexelCopyTextureInfo {
        texture,
        mip_level: 0,
        origin: Origin3d { x: at.x, y: at.y, z: 0 },
        aspect: TextureAspect::All,
    };
    let texel_bytes = texture.format().pixel_size().unwrap_or(4) as u32;
    let layout =
        TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(texel_bytes * size.x), rows_per_image: None };
    queue.write_texture(to, bytes, layout, extent(size));
}

fn extent(size: UVec2) -> Extent3d {
    Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_halves_exactly() {
        assert_eq!([0, 1, 2, 5, 255].map(half), [0, 0x3c00, 0x4000, 0x4500, 0x5bf8]);
    }

    #[test]
    fn bytes_keep_their_place_in_every_format() {
        let bytes = [1, 2, 3, 255];
        assert_eq!(encoded(&bytes, TextureFormat::Rgba8UnormSrgb), Some(bytes.to_vec()));
        assert_eq!(encoded(&bytes, TextureFormat::Bgra8Unorm), Some(vec![3, 2, 1, 255]));
        assert_eq!(encoded(&bytes, TextureFormat::Rgba16Float).map(|b| b.len()), Some(8));
        assert_eq!(encoded(&bytes, TextureFormat::R8Unorm), None);
    }
}
