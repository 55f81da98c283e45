//! The files in use as one texture, at the binding of a view that Bevy reserves for transmission.
//!
//! Bevy's view bind group has no binding for plugins. Binding 24 is in every view's layout, and Bevy puts a
//! texture there only if the view draws something transmissive. A view without transmission gets the words
//! alone, in `Rgba8Unorm`. A view with transmission gets one texture of the format that Bevy needs: the
//! picture's rows above, as Bevy copies them, and the words below. Bevy's transmission shader is patched to
//! take its texels from the picture alone.

use std::borrow::Cow;

use bevy::ecs::prelude::*;
use bevy::image::TextureFormatPixelInfo;
use bevy::log::warn_once;
use bevy::math::UVec2;
use bevy::pbr::{Transmissive3d, ViewTransmissionTexture};
use bevy::platform::collections::HashMap;
use bevy::platform::collections::hash_map::Entry;
use bevy::render::Extract;
use bevy::render::camera::ExtractedCamera;
use bevy::render::render_phase::ViewSortedRenderPhases;
use bevy::render::render_resource::{
    Extent3d, FilterMode, Origin3d, Sampler, SamplerDescriptor, TexelCopyBufferLayout, TexelCopyTextureInfo,
    Texture, TextureAspect, TextureDescriptor, TextureDimension, TextureFormat, TextureId, TextureUsages,
    TextureView,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::view::ExtractedView;

use crate::DeviceLimits;
use crate::encode::encoded;
use crate::in_use::{FileInUse, FilesInUse, March};
use crate::layout::Layout;
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
    if in_use.is_changed() && extracted.files != in_use.files {
        extracted.files.clone_from(&in_use.files);
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
    /// Words below a picture, by the picture's size and format, and for how many frames no view has used
    /// them.
    below: HashMap<(UVec2, TextureFormat), (WordTexture, u32)>,
}

impl WordTextures {
    /// Brings the textures up to date. If only settings have changed, less than 5 KiB per file is written.
    fn take(
        &mut self,
        (device, queue): (&RenderDevice, &RenderQueue),
        max_side: u32,
        (version, files): (u64, &[FileInUse]),
        pools: &Pools,
    ) {
        let has_words = self.files.len() == files.len()
            && self.files.iter().zip(files).all(|(a, b)| a.texels == b.texels);
        match &self.words {
            Some(_) if has_words => {
                for words in self.all() {
                    words.write_parameters(queue, files);
                }
            }
            _ => {
                self.below.clear();
                // A layout always exists, because files that do not fit are not in use.
                let layout = Layout::below(UVec2::ZERO, all_texels(files), max_side).unwrap_or_default();
                let size = layout.size(all_texels(files));
                let same = self.words.take().filter(|words| words.texture.size() == extent(size));
                let mut words =
                    same.unwrap_or_else(|| WordTexture::new(device, size, layout, TextureFormat::Rgba8Unorm));
                words.layout = layout;
                words.write_all(queue, files, pools);
                self.words = Some(words);
            }
        }
        self.version = version;
        self.files = files.to_vec();
    }

    /// All textures with the words.
    fn all(&self) -> impl Iterator<Item = &WordTexture> {
        self.words.iter().chain(self.below.values().map(|(words, _)| words))
    }

    /// Writes the changes of pools in this frame.
    fn take_writes(&self, queue: &RenderQueue, pools: &mut Pools) {
        pools.take_writes(|pool, first, bytes| {
            for words in self.all() {
                // A streamed file in several places is written once for each place.
                for (file, row) in self.files.iter().zip(words.layout.first_rows(all_texels(&self.files))) {
                    if file.texels == Texels::Pool(pool) {
                        words.write(queue, row, words.layout.width(&file.texels), first, bytes);
                    }
                }
            }
        });
    }
}

fn all_texels(files: &[FileInUse]) -> impl Iterator<Item = &Texels> + Clone {
    files.iter().map(|file| &file.texels)
}

/// A texture with words.
#[derive(Clone)]
struct WordTexture {
    texture: Texture,
    view: TextureView,
    sampler: Sampler,
    layout: Layout,
}

/// On views whose binding has the words: the texture that was put there last.
#[derive(Component)]
pub(crate) struct HasWords(TextureId);

/// Number of frames for which an unused texture is kept: glass enters and leaves the view as a camera turns.
const KEPT_FRAMES: u32 = 300;

/// Bytes of texels in a row of all texels of a file, or of the directory.
struct Part<'a> {
    /// First row of the file, and its width.
    row: u32,
    width: u32,
    /// First texel.
    first: u32,
    bytes: Cow<'a, [u8]>,
}

/// Returns the parts that depend on settings: each file's headers and the directory.
fn parameters(files: &[FileInUse], layout: Layout) -> Vec<Part<'_>> {
    let listed = files.iter().filter(|file| file.is_ready).count();
    let all_rows = layout.all_rows(all_texels(files));
    let mut directory = vec![DIRECTORY_MAGIC, listed as u32, all_rows, layout.picture.x, layout.picture.y];
    directory.resize(FILE_WORDS[0], 0);
    let place = |texels: PoolTexels| {
        let mut listed = files.iter().filter(|file| file.is_ready);
        listed.position(|file| file.texels == Texels::Pool(texels)).unwrap_or(0) as u32
    };
    let mut parts = Vec::new();
    for (file, row) in files.iter().zip(layout.first_rows(all_texels(files))) {
        let width = layout.width(&file.texels);
        if file.is_ready {
            let alone = u32::from(file.is_alone(files));
            directory.extend([row - layout.picture.y, width.ilog2(), file.way.code(), alone]);
            if let Some(March { slope: [x, y], other }) = file.march {
                directory.extend([x as u32, y as u32, place(other)]);
            }
            directory.resize(directory.len().next_multiple_of(FILE_WORDS[1]), 0);
        }
        parts.push(Part { row, width, first: 0, bytes: Cow::from(&file.header) });
    }
    let bytes: Vec<u8> = directory.into_iter().flat_map(u32::to_le_bytes).collect();
    let row = layout.picture.y + all_rows - 1;
    parts.push(Part { row, width: layout.size(all_texels(files)).x, first: 0, bytes: bytes.into() });
    parts
}

/// Gives every 3D view the words of the files in use.
pub(crate) fn give_words(
    mut commands: Commands,
    files: Res<ExtractedFiles>,
    (mut textures, mut pools): (ResMut<WordTextures>, ResMut<Pools>),
    (device, queue, limits): (Res<RenderDevice>, Res<RenderQueue>, Res<DeviceLimits>),
    transmissive: Res<ViewSortedRenderPhases<Transmissive3d>>,
    views: Query<(Entity, &ExtractedView, &ExtractedCamera)>,
    given: Query<(Entity, &HasWords, Option<&ViewTransmissionTexture>, Has<ExtractedView>)>,
) {
    // Remove the texture from cameras that no longer draw.
    for (entity, words, texture, is_drawn) in &given {
        if files.files.is_empty() || !is_drawn {
            let mut entity = commands.entity(entity);
            entity.remove::<HasWords>();
            // Keep any other texture: in views with transmission, Bevy has set its own for this frame.
            if texture.is_some_and(|texture| texture.texture.id() == words.0) {
                entity.remove::<ViewTransmissionTexture>();
            }
        }
    }
    if files.files.is_empty() {
        if textures.words.is_some() {
            *textures = WordTextures { version: textures.version, ..Default::default() };
        }
        pools.take_writes(|_, _, _| ());
        return;
    }
    if textures.version != files.version {
        textures.take((&device, &queue), limits.max_texture_side, (files.version, &files.files), &pools);
    }
    textures.take_writes(&queue, &mut pools);
    let (mut used, mut of_views) = (Vec::new(), Vec::new());
    for (entity, view, camera) in &views {
        of_views.extend(camera.physical_target_size.map(|size| (size, view.target_format)));
        let Some(phase) = transmissive.get(&view.retained_view_entity) else { continue };
        let words = if phase.items.is_empty() {
            textures.words.clone()
        } else {
            let Some(picture) = camera.physical_target_size else { continue };
            let key = (picture, view.target_format);
            used.push(key);
            let known = textures.below.get(&key).map(|(words, _)| words.clone());
            match known.map_or_else(|| below_a_picture(&device, *limits, &files.files, key), Ok) {
                Ok(words) => {
                    if let Entry::Vacant(entry) = textures.below.entry(key) {
                        words.write_all(&queue, &files.files, &pools);
                        entry.insert((words.clone(), 0));
                    }
                    Some(words)
                }
                Err(reason) => {
                    warn_once!(
                        "a view with transmissive materials has no baked shadows: {reason}; its surfaces are lit as if \
                         nothing baked cast a shadow"
                    );
                    None
                }
            }
        };
        let Some(WordTexture { texture, view, sampler, .. }) = words else { continue };
        commands
            .entity(entity)
            .insert((HasWords(texture.id()), ViewTransmissionTexture { texture, view, sampler }));
    }
    textures.below.retain(|key, (_, unused_frames)| {
        *unused_frames = if used.contains(key) { 0 } else { *unused_frames + 1 };
        *unused_frames <= KEPT_FRAMES && of_views.contains(key)
    });
}

/// Returns a texture with a picture's rows above and room for the words below, or the reason why it cannot be
/// made.
fn below_a_picture(
    device: &RenderDevice,
    limits: DeviceLimits,
    files: &[FileInUse],
    (picture, format): (UVec2, TextureFormat),
) -> Result<WordTexture, String> {
    if encoded(&[], format).is_none() {
        return Err(format!("it draws into {format:?}, which cannot hold them"));
    }
    let max_side = limits.max_texture_side;
    let layout = Layout::below(picture, all_texels(files), max_side).ok_or_else(|| {
        format!(
            "its picture of {} x {} and the files' words do not fit a texture with sides of {max_side}",
            picture.x, picture.y
        )
    })?;
    Ok(WordTexture::new(device, layout.size(all_texels(files)), layout, format))
}

impl WordTexture {
    fn new(device: &RenderDevice, size: UVec2, layout: Layout, format: TextureFormat) -> Self {
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
        // Use the same sampler as Bevy does for transmission.
        let sampler = device.create_sampler(&SamplerDescriptor {
            mag_filter: FilterMode::Linear,
            min_filter: FilterMode::Linear,
            ..Default::default()
        });
        Self { texture, view, sampler, layout }
    }

    /// Writes the parts that depend on settings.
    fn write_parameters(&self, queue: &RenderQueue, files: &[FileInUse]) {
        for part in parameters(files, self.layout) {
            self.write(queue, part.row, part.width, part.first, &part.bytes);
        }
    }

    /// Writes all files and the directory. Of a pool, only the part that has been written to is copied.
    fn write_all(&self, queue: &RenderQueue, files: &[FileInUse], pools: &Pools) {
        for (file, row) in files.iter().zip(self.layout.first_rows(all_texels(files))) {
            let bytes = match &file.texels {
                Texels::Whole(texture) => texture.bytes(),
                Texels::Pool(pool) => pools.bytes(*pool),
            };
            self.write(queue, row, self.layout.width(&file.texels), 0, bytes);
        }
        self.write_parameters(queue, files);
    }

    /// Writes texels of a file in the texture's format. The file begins in row `row` and is `width` texels
    /// wide.
    fn write(&self, queue: &RenderQueue, row: u32, width: u32, first: u32, bytes: &[u8]) {
        let texture = &self.texture;
        // Textures are created only in formats that can hold words.
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
}

fn extent(size: UVec2) -> Extent3d {
    Extent3d { width: size.x, height: size.y, depth_or_array_layers: 1 }
}
