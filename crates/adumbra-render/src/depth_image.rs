//! Uploads depths into a depth texture by drawing them, because depth textures cannot be the target of a
//! copy. The shader is passes/depth_image.wgsl.

use adumbra_shaders::{assemble, source};
use wgpu::{BindGroupLayout, CompareFunction, LoadOp, ShaderStages, TextureFormat, TextureView};

use crate::error::Result;
use crate::gpu::{Gpu, binding};

/// The pass for textures of one format.
pub struct DepthImagePass {
    layout: BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl DepthImagePass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu, format: TextureFormat) -> Self {
        let layout = gpu.layout("depth_image", ShaderStages::FRAGMENT, &[binding::LOADED]);
        let pipeline = pipeline(gpu, &layout, format);
        Self { layout, pipeline }
    }

    /// Replaces the whole of `to`, a texture of `size` texels, with `depths`, row 0 at the top.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn draw(&self, gpu: &Gpu, to: &TextureView, size: [u32; 2], depths: &[f32]) -> Result<()> {
        let image = gpu.float_texture("depth_image", size, depths).create_view(&Default::default());
        let group = gpu.bind("depth_image", &self.layout, vec![wgpu::BindingResource::TextureView(&image)]);
        let mut encoder = gpu.encoder("depth_image");
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("depth_image"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: to,
                depth_ops: Some(wgpu::Operations { load: LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        gpu.finish(encoder.finish())
    }
}

fn pipeline(gpu: &Gpu, layout: &BindGroupLayout, format: TextureFormat) -> wgpu::RenderPipeline {
    let module = gpu.shader("depth_image", assemble(&[source::DEPTH_IMAGE]));
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("depth_image"),
        layout: Some(&gpu.pipeline_layout("depth_image", &[Some(layout)])),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("depth_image_vertex"),
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Always),
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
    })
}
