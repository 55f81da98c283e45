//! Words in an RGBA8 texture, read texel by texel or decoded into a storage buffer at load. Source: *The
//! Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm* (2021), §3.3.2. The pages
//! are those of [`crate::tree::texture`], unchanged from their files, one per array layer.

use adumbra_render::gpu::binding;
use adumbra_render::voxel::WordBuffers;
use adumbra_render::{Fix, Gpu, RenderError, Result};
use adumbra_shaders::constants::LIST_GROUP;
use adumbra_shaders::{Source, assemble};
use wgpu::{BindingType, ShaderStages, TextureSampleType, TextureUsages, TextureViewDimension};

use super::shaders::{self, DecodeParams};
use crate::tree::TextureError;
use crate::tree::texture::{self, Page};

/// Largest number of workgroups per row.
const MAX_ROW: u64 = 65535;

/// Pages on the GPU, in the format that wgsl/access/words_texture.wgsl reads.
pub struct PageTexture {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl PageTexture {
    /// Its binding type.
    pub(crate) const BINDING: BindingType =
        binding::texture(TextureSampleType::Uint, TextureViewDimension::D2Array);

    /// Encodes words into pages as large as the device supports, and uploads them.
    ///
    /// # Errors
    /// Returns the errors of [`PageTexture::new`].
    pub fn from_words(gpu: &Gpu, words: &[u32]) -> Result<Self> {
        let side = gpu.max_texture_side().min(texture::MAX_SIDE);
        let pages = texture::encode(words, &[], side).map_err(wrong_pages)?;
        Self::upload(gpu, &pages)
    }

    /// Checks that the pages belong to one export, and uploads them unchanged.
    ///
    /// # Errors
    /// Returns [`RenderError::Other`] if they do not, and [`RenderError::TooLarge`] or
    /// [`RenderError::VoxelLimit`] if the device cannot hold them.
    pub fn new(gpu: &Gpu, pages: &[Page]) -> Result<Self> {
        texture::decode(pages).map_err(wrong_pages)?;
        Self::upload(gpu, pages)
    }

    fn upload(gpu: &Gpu, pages: &[Page]) -> Result<Self> {
        let limits = gpu.device.limits();
        let (width, height) = pages.first().map_or((1, 1), |p| (p.width, p.height));
        if width.max(height) > limits.max_texture_dimension_2d {
            return Err(RenderError::VoxelLimit {
                what: "a page's side in pixels",
                value: width.max(height).into(),
                limit: limits.max_texture_dimension_2d.into(),
                fix: Fix::Other("export again with smaller pages"),
            });
        }
        if pages.len() as u64 > u64::from(limits.max_texture_array_layers) {
            return Err(RenderError::VoxelLimit {
                what: "the number of pages",
                value: pages.len() as u64,
                limit: limits.max_texture_array_layers.into(),
                fix: Fix::Other("export again with larger pages, or bake at a lower resolution"),
            });
        }
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("voxel-texture::pages"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: pages.len() as u32 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            // Integer format: no filtering, no colour space, every bit preserved.
            format: wgpu::TextureFormat::Rgba8Uint,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST | TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        for (z, page) in (0..).zip(pages) {
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: 0, y: 0, z },
                    aspect: wgpu::TextureAspect::All,
                },
                &page.rgba,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * page.width),
                    rows_per_image: None,
                },
                wgpu::Extent3d { width: page.width, height: page.height, depth_or_array_layers: 1 },
            );
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(TextureViewDimension::D2Array),
            ..Default::default()
        });
        gpu.check()?;
        Ok(Self { texture, view })
    }

    /// View of all pages.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// The WGSL file that reads the texture.
    pub fn access(&self) -> Source {
        shaders::WORDS_TEXTURE
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let t = &self.texture;
        4 * u64::from(t.width()) * u64::from(t.height()) * u64::from(t.depth_or_array_layers())
    }

    /// Decodes the first `words` words into storage buffers on the device.
    ///
    /// # Errors
    /// Returns the errors of [`WordBuffers::empty`], and any error that the device reports.
    pub fn decode(&self, gpu: &Gpu, words: u64) -> Result<WordBuffers> {
        let decoded = WordBuffers::empty(gpu, "voxel-texture::words", words)?;
        let outputs =
            gpu.layout("decode_texture", ShaderStages::COMPUTE, &[binding::UNIFORM, binding::STORAGE_OUT]);
        let inputs = gpu.layout("decode_texture", ShaderStages::COMPUTE, &[binding::UNIFORM, Self::BINDING]);
        let text = assemble(&[shaders::tree_declarations(), shaders::WORDS_TEXTURE, shaders::DECODE_TEXTURE]);
        let pipeline =
            gpu.compute("decode_texture", text, "decode_texture", &[Some(&outputs), Some(&inputs)]);
        let mut from = 0_u64;
        for buffer in decoded.buffers() {
            let params = DecodeParams { first_word: from as u32 };
            let uniform = gpu.uniform("decode_texture", &params.bytes());
            let output = gpu.bind(
                "decode_texture",
                &outputs,
                vec![uniform.as_entire_binding(), buffer.as_entire_binding()],
            );
            let pages = wgpu::BindingResource::TextureView(&self.view);
            let input = gpu.bind("decode_texture", &inputs, vec![uniform.as_entire_binding(), pages]);
            let mut encoder = gpu.encoder("decode_texture");
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &output, &[]);
            pass.set_bind_group(1, &input, &[]);
            let groups = (buffer.size() / 4).div_ceil(LIST_GROUP.into());
            let row = groups.min(MAX_ROW);
            pass.dispatch_workgroups(row as u32, groups.div_ceil(row) as u32, 1);
            drop(pass);
            gpu.finish(encoder.finish())?;
            from += buffer.size() / 4;
        }
        Ok(decoded)
    }
}

/// Words that are not the pages of a texture, or do not fit into them.
#[derive(Debug, thiserror::Error)]
#[error("the texture's pages: {0}")]
pub struct PagesError(pub TextureError);

fn wrong_pages(error: TextureError) -> RenderError {
    RenderError::Other(Box::new(PagesError(error)))
}
