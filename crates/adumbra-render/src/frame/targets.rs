//! The textures that a frame renders to.

use wgpu::{TextureFormat, TextureUsages};

use crate::error::{Fix, RenderError, Result};
use crate::gpu::Gpu;

/// Format of a camera's depth.
pub const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// Format of the shadow factor.
pub(crate) const FACTOR_FORMAT: TextureFormat = TextureFormat::R32Float;

/// A texture with its view.
pub struct Target {
    /// The texture.
    pub texture: wgpu::Texture,
    /// A view of the whole texture.
    pub view: wgpu::TextureView,
}

impl Target {
    /// Creates a 2-D texture of `size` texels with one mip level, and a view of it.
    pub fn new(gpu: &Gpu, label: &str, size: [u32; 2], format: TextureFormat, usage: TextureUsages) -> Self {
        let texture = gpu.texture(label, size, format, usage);
        Self { view: texture.create_view(&Default::default()), texture }
    }
}

/// The render targets of frames of one size.
pub struct Targets {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Camera depth, reversed.
    pub depth: Target,
    /// World normals.
    pub normal: Target,
    /// Base colour.
    pub color: Target,
    /// Shadow factor as looked up.
    pub factor: Target,
    /// Shadow factor after a technique's screen-space passes, if it has any.
    pub filtered: Target,
    /// The finished picture.
    pub picture: Target,
}

impl Targets {
    /// Creates targets of `width` × `height` pixels.
    ///
    /// # Errors
    /// Returns [`RenderError::TooLarge`] if the device has no textures of that size.
    pub fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<Self> {
        let limit = gpu.max_texture_side();
        if width.max(height) > limit {
            return Err(RenderError::TooLarge {
                what: format!("a picture of {width} x {height} pixels"),
                bytes: u64::from(width) * u64::from(height) * 4,
                limit: u64::from(limit) * u64::from(limit) * 4,
                fix: Fix::SmallerPicture,
            });
        }
        let target = |label, format, usage| {
            let usage = usage | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
            Target::new(gpu, label, [width, height], format, usage)
        };
        let drawn = TextureUsages::RENDER_ATTACHMENT;
        let written = TextureUsages::STORAGE_BINDING;
        Ok(Self {
            size: [width, height],
            depth: target("frame::depth", DEPTH_FORMAT, drawn),
            normal: target("frame::normal", TextureFormat::Rgba16Float, drawn),
            color: target("frame::color", TextureFormat::Rgba8UnormSrgb, drawn),
            factor: target("frame::factor", FACTOR_FORMAT, written),
            filtered: target("frame::filtered", FACTOR_FORMAT, written),
            picture: target("frame::picture", TextureFormat::Rgba8Unorm, written),
        })
    }
}
