//! Draws world-space lines over a displayed picture.

use adumbra_shaders::{assemble, source};
use wgpu::{BindingResource, BufferUsages, ShaderStages, VertexFormat};

use super::pass::{SHOWN_FORMAT, ShownPicture};
use crate::error::Result;
use crate::gpu::{Gpu, binding};
use crate::renderer::Renderer;

/// A line segment in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldLine {
    /// End points, world positions.
    pub ends_world: [[f64; 3]; 2],
    /// Colour, display-encoded.
    pub color: [f32; 3],
}

/// The pass that draws lines.
pub struct LinePass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

const POINT: [wgpu::VertexAttribute; 2] = [
    wgpu::VertexAttribute { format: VertexFormat::Float32x4, offset: 0, shader_location: 0 },
    wgpu::VertexAttribute { format: VertexFormat::Float32x4, offset: 16, shader_location: 1 },
];

impl LinePass {
    /// Builds the pipeline.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let bindings = [binding::UNIFORM, binding::DEPTH, binding::UNIFORM];
        let layout = gpu.layout("lines", ShaderStages::VERTEX_FRAGMENT, &bindings);
        let module = gpu.shader("lines", assemble(&[source::LINES]));
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("lines"),
            layout: Some(&gpu.pipeline_layout("lines", &[Some(&layout)])),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("lines_vertex"),
                compilation_options: Default::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: 32,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &POINT,
                })],
            },
            primitive: wgpu::PrimitiveState {
                topology: wgpu::PrimitiveTopology::LineList,
                ..Default::default()
            },
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("lines_fragment"),
                compilation_options: Default::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: SHOWN_FORMAT,
                    blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::COLOR,
                })],
            }),
            multiview_mask: None,
            cache: None,
        });
        gpu.check()?;
        Ok(Self { layout, pipeline })
    }
}

impl Renderer {
    /// Draws lines over a picture of the last frame, whose eye is `anchor_world`.
    ///
    /// # Errors
    /// Returns whatever error the device reports.
    pub fn draw_lines(
        &self,
        pass: &LinePass,
        picture: &ShownPicture,
        anchor_world: [f64; 3],
        lines: &[WorldLine],
    ) -> Result<()> {
        let Some(targets) = self.targets().filter(|_| !lines.is_empty()) else { return Ok(()) };
        let gpu = self.gpu();
        let point = |p: [f64; 3], c: [f32; 3]| {
            let r: [f32; 3] = std::array::from_fn(|a| (p[a] - anchor_world[a]) as f32);
            [r[0], r[1], r[2], 1.0, c[0], c[1], c[2], 1.0]
        };
        let points: Vec<[f32; 8]> =
            lines.iter().flat_map(|line| line.ends_world.map(|end| point(end, line.color))).collect();
        let buffer = gpu.buffer("lines::points", bytemuck::cast_slice(&points), BufferUsages::VERTEX);
        let resources = vec![
            self.frame_buffer().as_entire_binding(),
            BindingResource::TextureView(&targets.depth.view),
            picture.params.as_entire_binding(),
        ];
        let group = gpu.bind("lines", &pass.layout, resources);
        let mut encoder = gpu.encoder("lines");
        {
            let target = &picture.target.view;
            let mut drawn = Gpu::color_pass(&mut encoder, "lines", target, wgpu::LoadOp::Load);
            drawn.set_pipeline(&pass.pipeline);
            drawn.set_bind_group(0, &group, &[]);
            drawn.set_vertex_buffer(0, buffer.slice(..));
            drawn.draw(0..points.len() as u32, 0..1);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.check()
    }
}
