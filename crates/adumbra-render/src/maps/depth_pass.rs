//! Draws casters into a layer: depth alone, by position, and masked ones cut by their alpha. Same stem as passes/map_depth.wgsl.
//!
//! Reads a layer's uniform and an instance list, writes one layer; both sides of every triangle cast. No depth bias: receivers are
//! moved instead. Where the device lacks depth clip control the fit has its near plane before every caster
//! ([`super::cascades::depth_range`]).

use adumbra_shaders::layout::MapLayer;
use adumbra_shaders::{assemble, source};
use wgpu::{CompareFunction, Features, LoadOp, ShaderStages, TextureFormat};

use crate::gpu::{Gpu, binding};
use crate::scene::{CASTER_LAYOUT, CORNER_LAYOUT, InstanceList, SceneBuffers, material_layout};

/// The pass and its pipelines.
pub(crate) struct DepthPass {
    layer_layout: wgpu::BindGroupLayout,
    opaque: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
}

/// Where a layer lies, on the GPU.
pub(crate) struct LayerUniform {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl LayerUniform {
    /// For the layer as shaders take it, relative to `anchor_world`.
    pub(crate) fn write(&self, gpu: &Gpu, layer: &MapLayer, anchor_world: [f64; 3]) {
        let anchor = [anchor_world[0] as f32, anchor_world[1] as f32, anchor_world[2] as f32, 0.0];
        let mut bytes = layer.bytes();
        bytes.extend_from_slice(bytemuck::bytes_of(&anchor));
        gpu.queue.write_buffer(&self.buffer, 0, &bytes);
    }
}

impl DepthPass {
    pub(crate) fn new(gpu: &Gpu, format: TextureFormat) -> Self {
        let layer_layout = gpu.layout("map_depth", ShaderStages::VERTEX, &[binding::UNIFORM]);
        let material = material_layout(gpu);
        let module = gpu.shader("map_depth", assemble(&[source::MAP_DEPTH]));
        let pipeline =
            |vertex, fragment: Option<&str>, buffers, groups: &[Option<&wgpu::BindGroupLayout>]| {
                gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(vertex),
                    layout: Some(&gpu.pipeline_layout("map_depth", groups)),
                    vertex: wgpu::VertexState {
                        module: &module,
                        entry_point: Some(vertex),
                        compilation_options: Default::default(),
                        buffers,
                    },
                    primitive: wgpu::PrimitiveState {
                        unclipped_depth: gpu.has(Features::DEPTH_CLIP_CONTROL),
                        ..Default::default()
                    },
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(CompareFunction::Less),
                        stencil: Default::default(),
                        bias: Default::default(),
                    }),
                    multisample: Default::default(),
                    fragment: fragment.map(|entry| wgpu::FragmentState {
                        module: &module,
                        entry_point: Some(entry),
                        compilation_options: Default::default(),
                        targets: &[],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            };
        let opaque = pipeline("map_vertex", None, &CASTER_LAYOUT, &[Some(&layer_layout)]);
        let both = [Some(&layer_layout), Some(&material)];
        let masked = pipeline("map_masked_vertex", Some("map_masked_fragment"), &CORNER_LAYOUT, &both);
        Self { layer_layout, opaque, masked }
    }

    pub(crate) fn uniform(&self, gpu: &Gpu) -> LayerUniform {
        let buffer = gpu.uniform("map_depth", &[0; 80]);
        let group = gpu.bind("map_depth", &self.layer_layout, vec![buffer.as_entire_binding()]);
        LayerUniform { buffer, group }
    }

    /// Draws the casters of `parts` into `target`, over what is there if `keep`.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        layer: &LayerUniform,
        target: &wgpu::TextureView,
        keep: bool,
        parts: &[(&SceneBuffers, &InstanceList)],
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("map_depth"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: target,
                depth_ops: Some(wgpu::Operations {
                    load: if keep { LoadOp::Load } else { LoadOp::Clear(1.0) },
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        for (scene, list) in parts {
            pass.set_pipeline(&self.opaque);
            pass.set_bind_group(0, &layer.group, &[]);
            scene.draw_opaque_casters(&mut pass, list);
            scene.draw_masked_casters(&mut pass, list, |pass| {
                pass.set_pipeline(&self.masked);
                pass.set_bind_group(0, &layer.group, &[]);
            });
        }
    }
}
