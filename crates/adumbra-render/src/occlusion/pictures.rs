//! The textures that the passes write, for one frame size.

use wgpu::{TextureFormat, TextureUsages};

use super::settings::{Normals, OcclusionSettings};
use crate::frame::Target;
use crate::gpu::Gpu;

/// Ambient visibility and view depth.
pub(crate) const AMBIENT_FORMAT: TextureFormat = TextureFormat::Rg32Float;
/// World normals computed from depth: 32-bit floats, so that no rounding differs between devices.
pub(super) const NORMAL_FORMAT: TextureFormat = TextureFormat::Rgba32Float;
/// Visibility, view depth, number of frames, 0.
pub(super) const HISTORY_FORMAT: TextureFormat = TextureFormat::Rgba32Float;

pub(super) struct Pictures {
    pub(super) frame_size: [u32; 2],
    pub(super) view_depth: Target,
    /// World normals, if they are computed from depth.
    pub(super) normals: Option<Target>,
    /// The estimate and the results of later passes, which alternate between the two.
    pub(super) ambient: [Target; 2],
    /// History, which alternates between the two from frame to frame.
    pub(super) history: Option<[Target; 2]>,
    /// Result at the frame's size, if the others are half of it.
    pub(super) whole: Option<Target>,
    pub(super) bytes: u64,
}

impl Pictures {
    pub(super) fn new(gpu: &Gpu, settings: &OcclusionSettings, frame_size: [u32; 2]) -> Self {
        let mut bytes = 0;
        let mut picture = |format: TextureFormat, [width, height]: [u32; 2]| {
            let texel = u64::from(format.block_copy_size(None).unwrap_or(4));
            bytes += u64::from(width) * u64::from(height) * texel;
            let usage =
                TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
            Target::new(gpu, "occlusion::picture", [width, height], format, usage)
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
