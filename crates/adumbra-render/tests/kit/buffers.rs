//! Depth and normals made up in memory, as a frame's G-buffer holds them.

use adumbra_render::frame::{DEPTH_FORMAT, Target};
use adumbra_render::gpu::binding;
use adumbra_render::occlusion::{OcclusionInput, OcclusionPasses};
use adumbra_render::{Gpu, Result};
use adumbra_shaders::layout::Frame;
use adumbra_shaders::{assemble, source};
use wgpu::{ShaderStages, TextureFormat, TextureUsages};

/// What an estimator of ambient occlusion reads.
pub(crate) struct Buffers {
    pub(crate) depth: Target,
    pub(crate) normal: Target,
}

impl Buffers {
    /// Stored depths and world normals, row 0 at the top; normals keep all of their bits.
    pub(crate) fn new(gpu: &Gpu, size: [u32; 2], depth: &[f32], normal: &[[f32; 3]]) -> Self {
        let target = |format, usage| {
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("kit::buffers"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            Target { view: texture.create_view(&Default::default()), texture }
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
        buffers.write_depth(gpu, size, depth);
        buffers
    }

    /// By drawing: no copy goes into a depth texture.
    fn write_depth(&self, gpu: &Gpu, size: [u32; 2], depth: &[f32]) {
        let layout = gpu.layout("depth_image", ShaderStages::FRAGMENT, &[binding::LOADED]);
        let image = gpu.float_texture("depth_image", size, depth).create_view(&Default::default());
        let group = gpu.bind("depth_image", &layout, vec![wgpu::BindingResource::TextureView(&image)]);
        let module = gpu.shader("depth_image", assemble(&[source::DEPTH_IMAGE]));
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("depth_image"),
            layout: Some(&gpu.pipeline_layout("depth_image", &[Some(&layout)])),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("depth_image_vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("depth_image_fragment"),
                compilation_options: Default::default(),
                targets: &[],
            }),
            multiview_mask: None,
            cache: None,
        });
        let mut encoder = gpu.encoder("depth_image");
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("depth_image"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth.view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        gpu.finish(encoder.finish()).unwrap();
    }

    /// What ambient occlusion makes of them.
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
