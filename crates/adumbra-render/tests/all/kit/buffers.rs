//! Synthetic depth and normals in the form of a frame's G-buffer.

use adumbra_render::depth_image::DepthImagePass;
use adumbra_render::frame::{DEPTH_FORMAT, Target};
use adumbra_render::occlusion::{OcclusionInput, OcclusionPasses};
use adumbra_render::{Gpu, Result};
use adumbra_shaders::layout::Frame;
use wgpu::{TextureFormat, TextureUsages};

/// The input textures of ambient occlusion.
pub(crate) struct Buffers {
    pub(crate) depth: Target,
    pub(crate) normal: Target,
}

impl Buffers {
    /// Uploads stored depths and world normals, row 0 at the top. Normals are stored as 32-bit floats without
    /// loss.
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2], depth: &[f32], normal: &[[f32; 3]]) -> Self {
        let target = |format, usage| {
            Target::new(gpu, "kit::buffers", size, format, usage | TextureUsages::TEXTURE_BINDING)
        };
        let buffers = Self {
            depth: target(DEPTH_FORMAT, TextureUsages::RENDER_ATTACHMENT),
            normal: target(TextureFormat::Rgba32Float, TextureUsages::COPY_DST),
        };
        let bytes: Vec<u8> =
            normal.iter().flat_map(|n| [n[0], n[1], n[2], 0.0]).flat_map(f32::to_le_bytes).collect();
        let rows = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(16 * size[0]),
            rows_per_image: None,
        };
        gpu.queue.write_texture(
            buffers.normal.texture.as_image_copy(),
            &bytes,
            rows,
            buffers.normal.texture.size(),
        );
        let pass = DepthImagePass::new(gpu, DEPTH_FORMAT);
        pass.draw(gpu, &buffers.depth.view, size, depth).unwrap();
        buffers
    }

    /// Computes ambient visibility from them.
    pub(crate) fn occlude(&self, gpu: &Gpu, frame: &Frame, passes: &mut OcclusionPasses) -> Result<Vec<f32>> {
        let input = OcclusionInput { frame, depth: &self.depth.view, normal: &self.normal.view };
        passes.prepare(gpu, frame);
        let mut encoder = gpu.encoder("occlude");
        passes.encode_surfaces(gpu, &mut encoder, &input);
        passes.encode_estimate(gpu, &mut encoder, &input);
        passes.encode_filter(gpu, &mut encoder, &input);
        gpu.finish(encoder.finish())?;
        passes.read(gpu)
    }
}
