//! Draws casters into a layer. Depth alone needs only positions, except that masked casters are cut by their
//! alpha: passes/map_depth.wgsl. With normals, all casters are drawn by their corners:
//! passes/map_normals.wgsl.
//!
//! Reads a layer's uniform and an instance list, and writes one layer. Both sides of every triangle cast.
//! There is no depth bias: receivers are moved instead. On devices without depth clip control, the fit places
//! its near plane in front of every caster ([`super::cascades::depth_range`]).

use adumbra_shaders::layout::{GpuType, MapLayer};
use adumbra_shaders::{assemble, source};
use wgpu::{CompareFunction, Features, LoadOp, ShaderStages, TextureFormat};

use crate::gpu::{Gpu, binding};
use crate::scene::{CASTER_LAYOUT, CORNER_LAYOUT, InstanceList, SceneBuffers, material_layout};

/// Format of normals: the two bytes of core/octahedral.wgsl, in world space, flipped towards the sun before
/// they are packed. A normal that is edge-on to the light may decode to up to a degree beyond edge-on. Texels
/// without a caster hold (0, 0), which encodes no normal.
pub(crate) const NORMAL_FORMAT: TextureFormat = TextureFormat::Rg8Unorm;

/// The outputs of the pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct DepthPassOptions {
    /// Depth format, from a [`DepthPrecision`](super::DepthPrecision).
    pub(crate) format: TextureFormat,
    /// Whether to also write the nearest caster's geometric normal, in [`NORMAL_FORMAT`].
    pub(crate) normals: bool,
}

/// The attachments that a layer is drawn into.
#[derive(Clone, Copy)]
pub(crate) struct LayerTarget<'a> {
    /// One layer of depth.
    pub(crate) depth: &'a wgpu::TextureView,
    /// One layer of normals, if and only if the pass writes them.
    pub(crate) normals: Option<&'a wgpu::TextureView>,
}

/// The pass and its pipelines.
pub(crate) struct DepthPass {
    layer_layout: wgpu::BindGroupLayout,
    opaque: wgpu::RenderPipeline,
    masked: wgpu::RenderPipeline,
    normals: bool,
}

/// Uniform and bind group with a layer's placement.
pub(crate) struct LayerUniform {
    buffer: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl LayerUniform {
    /// Writes the layer as shaders take it, relative to the anchor of the instance lists drawn into it.
    pub(crate) fn write(&self, gpu: &Gpu, layer: &MapLayer) {
        gpu.queue.write_buffer(&self.buffer, 0, &layer.bytes());
    }
}

impl DepthPass {
    pub(crate) fn new(gpu: &Gpu, options: DepthPassOptions) -> Self {
        let layer_layout = gpu.layout("map_depth", ShaderStages::VERTEX, &[binding::UNIFORM]);
        let material = material_layout(gpu);
        let (files, targets): (&[_], &[_]) = if options.normals {
            let target = wgpu::ColorTargetState::from(NORMAL_FORMAT);
            let files = &[
                source::OCTAHEDRAL,
                source::INSTANCE,
                source::SCENE_CORNER,
                source::MAP_LAYER,
                source::MAP_DEPTH,
                source::MAP_NORMALS,
            ];
            (files, &[Some(target)])
        } else {
            (&[source::INSTANCE, source::SCENE_CORNER, source::MAP_LAYER, source::MAP_DEPTH], &[])
        };
        let module = gpu.shader("map_depth", assemble(files));
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
                        format: options.format,
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
                        targets,
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            };
        let both = [Some(&layer_layout), Some(&material)];
        let by_corner = |vertex, fragment| pipeline(vertex, Some(fragment), &CORNER_LAYOUT, &both);
        let (opaque, masked) = if options.normals {
            let vertex = "map_normals_vertex";
            (by_corner(vertex, "map_normals_fragment"), by_corner(vertex, "map_normals_masked_fragment"))
        } else {
            let opaque = pipeline("map_vertex", None, &CASTER_LAYOUT, &[Some(&layer_layout)]);
            (opaque, by_corner("map_masked_vertex", "map_masked_fragment"))
        };
        Self { layer_layout, opaque, masked, normals: options.normals }
    }

    pub(crate) fn uniform(&self, gpu: &Gpu) -> LayerUniform {
        let buffer = gpu.uniform("map_depth", &[0; MapLayer::SIZE]);
        let group = gpu.bind("map_depth", &self.layer_layout, vec![buffer.as_entire_binding()]);
        LayerUniform { buffer, group }
    }

    /// Draws the casters of `parts` into `target`, over its contents if `keep`.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        layer: &LayerUniform,
        target: LayerTarget<'_>,
        keep: bool,
        parts: &[(&SceneBuffers, &InstanceList)],
    ) {
        let normals = target.normals.map(|view| wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: if keep { LoadOp::Load } else { LoadOp::Clear(wgpu::Color::TRANSPARENT) },
                store: wgpu::StoreOp::Store,
            },
        });
        let colors: &[_] = if normals.is_some() { &[normals] } else { &[] };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("map_depth"),
            color_attachments: colors,
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: target.depth,
                depth_ops: Some(wgpu::Operations {
                    load: if keep { LoadOp::Load } else { LoadOp::Clear(1.0) },
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        for (scene, list) in parts {
            if self.normals {
                scene.draw_caster_corners(&mut pass, list, |pass, masked| {
                    pass.set_pipeline(if masked { &self.masked } else { &self.opaque });
                    pass.set_bind_group(0, &layer.group, &[]);
                });
                continue;
            }
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

#[cfg(test)]
mod tests;
