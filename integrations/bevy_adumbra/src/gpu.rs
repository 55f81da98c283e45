//! The files in use as one texture, at the binding of a view that Bevy keeps for transmission.
//!
//! Bevy's view bind group has no place for a plugin. Binding 24 is in every view's layout, and Bevy puts a texture there
//! only where something transmissive is drawn. So a view without that gets the words as they are, in `Rgba8Unorm`. A
//! view with it gets one texture of the format that Bevy needs: the picture's rows above, as Bevy copies them, and the
//! words below. Transmission divides by the texture's own size, so it looks up the same texels as before.

use std::borrow::Cow;

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
use crate::encode::encoded;
use crate::in_use::{FileInUse, FilesInUse, March};
use crate::pools::Pools;
use crate::texels::{PoolTexels, Texels, rectangles};

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
    /// Brings the textures up to date. If only settings have changed, less than 5 KiB per file is written.
    fn take(
        &mut self,
        (device, queue): (&RenderDevice, &RenderQueue),
        (version, files): (u64, &[FileInUse]),
        pools: &Pools,
    ) {
        let has_words = self.files.len() == files.len()
            && self.files.iter().zip(files).all(|(a, b)| a.texels == b.texels);
        match &self.words {
            Some(_) if has_words => {
                for Part { row, width, first, bytes } in parameters(files) {
                    self.write(queue, row, width, first, &bytes);
                }
            }
            _ => {
                self.below.clear();
                let has_size = size(&self.files) == size(files);
                let same = self.words.take().filter(|_| has_size);
                let words =
                    same.unwrap_or_else(|| word_texture(device, size(files), TextureFormat::Rgba8Unorm));
                write_all(queue, &words.texture, 0, files, pools);
                self.words = Some(words);
            }
        }
        self.version = version;
        self.files = files.to_vec();
    }

    /// Writes some texels of a file, which begins in a row and has a width, to all textures.
    fn write(&self, queue: &RenderQueue, row: u32, width: u32, first: u32, bytes: &[u8]) {
        if let Some(words) = &self.words {
            write(queue, &words.texture, row, width, first, bytes);
        }
        for ((picture, _), below) in &self.below {
            write(queue, &below.texture, picture.y + row, width, first, bytes);
        }
    }

    /// Writes what has come to pools in this frame.
    fn take_writes(&self, queue: &RenderQueue, pools: &mut Pools) {
        let mut row = 0;
        let rows: Vec<_> = self
            .files
            .iter()
            .map(|file| {
                let at = row;
                row += file.texels.height();
                at
            })
            .collect();
        pools.take_writes(|pool, first, bytes| {
            let is_pool = |file: &FileInUse| file.texels == Texels::Pool(pool);
            if let Some(file) = self.files.iter().position(is_pool) {
                self.write(queue, rows[file], pool.width, first, bytes);
            }
        });
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
    let width = files.iter().map(|file| file.texels.width()).max().unwrap_or(1);
    UVec2::new(width, 1 + files.iter().map(|file| file.texels.height()).sum::<u32>())
}

/// Bytes of texels in a row of all texels of a file, or of the directory.
struct Part<'a> {
    /// First row of the file, and its width.
    row: u32,
    width: u32,
    /// First texel.
    first: u32,
    bytes: Cow<'a, [u8]>,
}

/// What depends on settings: each file's headers and the directory.
fn parameters(files: &[FileInUse]) -> Vec<Part<'_>> {
    let listed = files.iter().filter(|file| file.is_ready).count();
    let mut directory = vec![DIRECTORY_MAGIC, listed as u32, size(files).y];
    directory.resize(FILE_WORDS[0], 0);
    let place = |texels: PoolTexels| {
        let mut listed = files.iter().filter(|file| file.is_ready);
        listed.position(|file| file.texels == Texels::Pool(texels)).unwrap_or(0) as u32
    };
    let (mut row, mut parts) = (0, Vec::new());
    for file in files {
        let width = file.texels.width();
        if file.is_ready {
            let alone = u32::from(file.is_alone(files));
            directory.extend([row, width.ilog2(), file.way.code(), alone]);
            if let Some(March { slope: [x, y], other }) = file.march {
                directory.extend([x as u32, y as u32, place(other)]);
            }
            directory.resize(directory.len().next_multiple_of(FILE_WORDS[1]), 0);
        }
        parts.push(Part { row, width, first: 0, bytes: Cow::from(&file.header) });
        row += file.texels.height();
    }
    let bytes: Vec<u8> = directory.into_iter().flat_map(u32::to_le_bytes).collect();
    parts.push(Part { row, width: size(files).x, first: 0, bytes: bytes.into() });
    parts
}

/// Writes all files and the directory to a texture, from a row on. Of pools, that is what has been written to them.
fn write_all(queue: &RenderQueue, texture: &Texture, row: u32, files: &[FileInUse], pools: &Pools) {
    let mut at = row;
    for file in files {
        let bytes = match &file.texels {
            Texels::Whole(texture) => texture.bytes(),
            Texels::Pool(pool) => pools.bytes(*pool),
        };
        write(queue, texture, at, file.texels.width(), 0, bytes);
        at += file.texels.height();
    }
    for part in parameters(files) {
        write(queue, texture, row + part.row, part.width, part.first, &part.bytes);
    }
}

/// Gives every 3D view the words of the files in use.
pub(crate) fn give_words(
    mut commands: Commands,
    files: Res<ExtractedFiles>,
    (mut textures, mut pools): (ResMut<WordTextures>, ResMut<Pools>),
    (device, queue, limits): (Res<RenderDevice>, Res<RenderQueue>, Res<DeviceLimits>),
    transmissive: Res<ViewSortedRenderPhases<Transmissive3d>>,
    views: Query<(Entity, &ExtractedView, &ExtractedCamera, Has<HasWords>)>,
) {
    if files.files.is_empty() {
        if textures.words.is_some() {
            *textures = WordTextures { version: textures.version, ..Default::default() };
        }
        pools.take_writes(|_, _, _| ());
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
    if textures.version != files.version {
        textures.take((&device, &queue), (files.version, &files.files), &pools);
    }
    textures.take_writes(&queue, &mut pools);
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
                let words = below_a_picture(&device, &queue, *limits, (&files.files, &pools), key)?;
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
    (files, pools): (&[FileInUse], &Pools),
    (picture, format): (UVec2, TextureFormat),
) -> Option<WordTexture> {
    encoded(&[], format)?;
    let size = size(files);
    let whole = UVec2::new(picture.x.max(size.x), picture.y + size.y);
    if whole.max_element() > limits.max_texture_side {
        return None;
    }
    let words = word_texture(device, whole, format);
    write_all(queue, &words.texture, picture.y, files, pools);
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

/// Writes texels of a file, which begins in a row of a texture and has a width, in the texture's format.
fn write(queue: &RenderQueue, texture: &Texture, row: u32, width: u32, first: u32, bytes: &[u8]) {
    // A texture without a format for words is not made.
    let Some(bytes) = encoded(bytes, texture.format()) else { return };
    let texel_bytes = texture.format().pixel_size().unwrap_or(4);
    let mut offset = 0;
    for (at, size) in rectangles(first, (bytes.len() / texel_bytes) as u32, width) {
        let to = TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: Origin3d { x: at.x, y: row + at.y, z: 0 },
            aspect: TextureAspect::All,
        };
        let bytes_per_row = Some(texel_bytes as u32 * size.x);
        let layout = TexelCopyBufferLayout { offset, bytes_per_row, rows_per_image: None };
        queue.write_texture(to, &bytes, layout, extent(size));
        offset += u64::from(size.x * size.y) * texel_bytes as u64;
    }
}

fn extent(size: UVec2) -> Extent3d {
    Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 }
}
