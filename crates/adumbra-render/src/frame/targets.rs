//! The textures that a frame is drawn into.

use wgpu::{TextureFormat, TextureUsages};

use crate::error::{RenderError, Result};
use crate::gpu::Gpu;

/// Of a camera's depth.
pub const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// Of the shadow factor.
pub const FACTOR_FORMAT: TextureFormat = TextureFormat::R32Float;

/// A texture with its view.
pub struct Target {
    /// The texture.
    pub texture: wgpu::Texture,
    /// All of it.
    pub view: wgpu::TextureView,
}

/// The targets of a frame of one size.
pub struct Targets {
    /// Pixels.
    pub size: [u32; 2],
    /// Reversed depth.
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
    /// Targets of `width` × `height` pixels.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`].
    pub fn new(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<Self> {
        let limit = gpu.max_texture_side();
        if width.max(height) > limit {
            return Err(RenderError::TooLarge {
                what: format!("a picture of {width} x {height} pixels"),
                bytes: u64::from(width) * u64::from(height) * 4,
                limit: u64::from(limit) * u64::from(limit) * 4,
                mend: "draw a smaller one with --size, or with less --antialias",
            });
        }
        let target = |label, format, usage| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            Target { view: texture.create_view(&Default::default()), texture }
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
