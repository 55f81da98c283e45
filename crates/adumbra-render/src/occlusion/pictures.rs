//! What the passes write: made for one size of frame.

use wgpu::{TextureFormat, TextureUsages};

use super::passes::AMBIENT_FORMAT;
use super::settings::{Normals, OcclusionSettings};
use crate::frame::Target;
use crate::gpu::Gpu;

/// World normals made from depth: whole floats, of which no rounding differs from device to device.
pub(super) const NORMAL_FORMAT: TextureFormat = TextureFormat::Rgba32Float;
/// Visibility, view depth, frames, 0.
pub(super) const HISTORY_FORMAT: TextureFormat = TextureFormat::Rgba32Float;

pub(super) struct Pictures {
    pub(super) frame_size: [u32; 2],
    pub(super) view_depth: Target,
    /// Where they are made from depth.
    pub(super) normals: Option<Target>,
    /// The estimate, and what is made of it; two take turns.
    pub(super) ambient: [Target; 2],
    /// Two take turns from frame to frame.
    pub(super) history: Option<[Target; 2]>,
    /// Of the frame's size, where the others are half of it.
    pub(super) whole: Option<Target>,
    pub(super) bytes: u64,
}

impl Pictures {
    pub(super) fn new(gpu: &Gpu, settings: &OcclusionSettings, frame_size: [u32; 2]) -> Self {
        let mut bytes = 0;
        let mut picture = |format: TextureFormat, [width, height]: [u32; 2]| {
            let texel = u64::from(format.block_copy_size(None).unwrap_or(4));
            bytes += u64::from(width) * u64::from(height) * texel;
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("occlusion::picture"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: TextureUsages::STORAGE_BINDING
                    | TextureUsages::TEXTURE_BINDING
                    | TextureUsages::COPY_SRC,
                view_formats: &[],
            });
            Target { view: texture.create_view(&Default::default()), texture }
        };
        let size = settings.size(frame_size);
        let view_depth = picture(TextureFormat::R32Float, size);
        let normals = (settings.normals == Normals::Depth).then(|| picture(NORMAL_FORMAT, size));
        let ambient = [picture(AMBIENT_FORMAT, size), picture(AMBIENT_FORMAT, size)];
        let history = settings.reuse.then(|| [picture(HISTORY_FORMAT, size), picture(HISTORY_FORMAT, size)]);
        let whole = settings.half.then(|| picture(AMBIENT_FORMAT, frame_size));
        Self { frame_size, view_depth, normals, ambient, history, whole, bytes }
    }
}
