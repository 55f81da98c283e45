//! The G-buffer pass: draws the scene once into depth, normal and base colour.

use adumbra_shaders::{assemble, source};
use wgpu::{CompareFunction, ShaderStages, TextureFormat};

use super::{DEPTH_FORMAT, Targets};
use crate::gpu::{Gpu, binding};
use crate::scene::{CORNER_LAYOUT, InstanceList, SceneBuffers, material_layout};

/// The G-buffer pass and its pipelines.
pub struct GBuffer {
    frame_layout: wgpu::BindGroupLayout,
    opaque: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
}

impl GBuffer {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu) -> Self {
        let frame_layout = gpu.layout("gbuffer", ShaderStages::VERTEX_FRAGMENT, &[binding::UNIFORM]);
        let layout = gpu.pipeline_layout("gbuffer", &[Some(&frame_layout), Some(&material_layout(gpu))]);
        let module = gpu.shader(
            "gbuffer",
            assemble(&[source::INSTANCE, source::SRGB, source::SCENE_CORNER, source::GBUFFER]),
        );
        let target =
            |format| Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL });
        let targets = [target(TextureFormat::Rgba16Float), target(TextureFormat::Rgba8UnormSrgb)];
        let pipeline = |entry_point| {
            gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("gbuffer_vertex"),
                    compilation_options: Default::default(),
                    buffers: &CORNER_LAYOUT,
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH_FORMAT,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(CompareFunction::Greater),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry_point),
                    compilation_options: Default::default(),
                    targets: &targets,
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let (opaque, masked) = (pipeline("gbuffer_opaque"), pipeline("gbuffer_masked"));
        Self { frame_layout, opaque, masked }
    }

    /// Clears the targets and draws `parts` into them.
    pub fn encode<'a>(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::Buffer,
        targets: &Targets,
        parts: impl Iterator<Item = (&'a SceneBuffers, &'a InstanceList)>,
    ) {
        let group = gpu.bind("gbuffer", &self.frame_layout, vec![frame.as_entire_binding()]);
        let color = |view| {
            let ops = wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                store: wgpu::StoreOp::Store,
            };
            Some(wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops })
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("gbuffer"),
            color_attachments: &[color(&targets.normal.view), color(&targets.color.view)],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth.view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        for (scene, list) in parts {
            scene.draw_surfaces(&mut pass, list, |pass, masked| {
                pass.set_pipeline(if masked { &self.masked } else { &self.opaque });
                pass.set_bind_group(0, &group, &[]);
            });
        }
    }
}
