//! The finished picture: a plain sun and sky, the material's colour, the shadow factor and ambient
//! visibility. The arithmetic matches `adumbra_truth::picture`, its CPU twin.

use adumbra_scene::daylight::{GROUND_COLOR, SKY_COLOR, SUN_COLOR};
use adumbra_shaders::constants::PIXEL_GROUP;
use adumbra_shaders::layout::CompositeParams;
use adumbra_shaders::{assemble, source};
use wgpu::{BindingResource, ShaderStages, TextureFormat};

use crate::frame::Targets;
use crate::gpu::{Gpu, binding};

/// The composite pass.
pub struct Composite {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
    light: wgpu::Buffer,
    /// Ambient visibility used if none is given: a single texel of 1.
    open: wgpu::TextureView,
}

impl Composite {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        let bindings = [
            binding::UNIFORM,
            binding::DEPTH,
            binding::LOADED,
            binding::LOADED,
            binding::LOADED,
            binding::written(TextureFormat::Rgba8Unorm),
            binding::UNIFORM,
            binding::LOADED,
        ];
        let layout = gpu.layout("composite", ShaderStages::COMPUTE, &bindings);
        let text =
            assemble(&[source::SURFACE, source::VIEW_DEPTH, source::FRAME, source::SRGB, source::COMPOSITE]);
        let pipeline = gpu.compute("composite", text, "composite", &[Some(&layout)]);
        let single = |c: [f64; 3]| c.map(|c| c as f32);
        let params = CompositeParams {
            sun_color: single(SUN_COLOR),
            sky_color: single(SKY_COLOR),
            ground_color: single(GROUND_COLOR),
        };
        let open = gpu.float_texture("composite::open", [1, 1], &[1.0]).create_view(&Default::default());
        Self { layout, pipeline, light: gpu.uniform("composite::light", &params.bytes()), open }
    }

    /// Writes `targets.picture` from the G-buffer, `factor` and ambient visibility, if any.
    pub fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::Buffer,
        targets: &Targets,
        factor: &wgpu::TextureView,
        ambient: Option<&wgpu::TextureView>,
    ) {
        let view = BindingResource::TextureView;
        let group = gpu.bind(
            "composite",
            &self.layout,
            vec![
                frame.as_entire_binding(),
                view(&targets.depth.view),
                view(&targets.normal.view),
                view(&targets.color.view),
                view(factor),
                view(&targets.picture.view),
                self.light.as_entire_binding(),
                view(ambient.unwrap_or(&self.open)),
            ],
        );
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        let [w, h] = targets.size;
        pass.dispatch_workgroups(w.div_ceil(PIXEL_GROUP), h.div_ceil(PIXEL_GROUP), 1);
    }
}
