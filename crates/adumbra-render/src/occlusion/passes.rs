//! The passes on a device.

use adumbra_shaders::constants::PIXEL_GROUP;
use adumbra_shaders::layout::Frame;
use adumbra_shaders::{Source, assemble, source};
use wgpu::{BindGroupLayout, BindingResource, ComputePipeline, ShaderStages, TextureFormat, TextureUsages};

use super::estimator::Estimator;
use super::settings::{Filter, OcclusionSettings};
use super::taps::taps;
use crate::error::Result;
use crate::frame::Target;
use crate::gpu::{Gpu, binding};
use crate::readback::read_texture;

/// Ambient visibility and view depth.
pub const AMBIENT_FORMAT: TextureFormat = TextureFormat::Rg32Float;

/// What the passes read.
#[derive(Clone, Copy)]
pub struct OcclusionInput<'a> {
    /// The frame's uniform, as it is on the device too.
    pub frame: &'a Frame,
    /// The camera's depth.
    pub depth: &'a wgpu::TextureView,
    /// World normals.
    pub normal: &'a wgpu::TextureView,
}

/// The pipelines of one ambient occlusion, with its pictures.
pub struct OcclusionPasses {
    settings: OcclusionSettings,
    surface: Pass,
    estimate: Pass,
    filter: Option<Pass>,
    params: wgpu::Buffer,
    noise: wgpu::Buffer,
    pictures: Option<Pictures>,
}

/// One pipeline.
struct Pass {
    layout: BindGroupLayout,
    pipeline: ComputePipeline,
}

/// Made for one size of frame.
struct Pictures {
    frame_size: [u32; 2],
    view_depth: Target,
    /// The estimate, and what filters make of it; two take turns.
    ambient: [Target; 2],
    filter_params: [wgpu::Buffer; 2],
    bytes: u64,
}

impl OcclusionPasses {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu, settings: OcclusionSettings) -> Self {
        let mut estimate = vec![source::OCCLUSION, source::OCCLUSION_PASS];
        estimate.extend(estimator(settings.estimator));
        let filter = match settings.filter {
            Filter::None => None,
            _ => Some("bilateral_line"),
        };
        Self {
            surface: Pass::new(
                gpu,
                "occlusion_surface",
                &[source::OCCLUSION_SURFACE],
                &[binding::UNIFORM, binding::DEPTH, binding::written(TextureFormat::R32Float)],
            ),
            estimate: Pass::new(
                gpu,
                "occlude",
                &estimate,
                &[
                    binding::UNIFORM,
                    binding::UNIFORM,
                    binding::LOADED,
                    binding::LOADED,
                    binding::written(AMBIENT_FORMAT),
                ],
            ),
            filter: filter.map(|entry| {
                let bindings = [binding::UNIFORM, binding::LOADED, binding::written(AMBIENT_FORMAT)];
                Pass::new(gpu, entry, &[source::OCCLUSION_FILTER], &bindings)
            }),
            params: gpu.uniform("occlusion::params", &vec![0; size_of_params()]),
            noise: gpu.uniform("occlusion::noise", &taps(&settings).bytes()),
            pictures: None,
            settings,
        }
    }

    /// What it was made for.
    pub fn settings(&self) -> &OcclusionSettings {
        &self.settings
    }

    /// Other numbers for the same estimator and the same passes; false, and nothing done, where passes would differ.
    pub fn reshape(&mut self, gpu: &Gpu, settings: &OcclusionSettings) -> bool {
        let same = OcclusionSettings {
            shape: self.settings.shape,
            radius_world: self.settings.radius_world,
            ..*settings
        };
        if same != self.settings {
            return false;
        }
        self.settings = *settings;
        gpu.queue.write_buffer(&self.noise, 0, &taps(settings).bytes());
        true
    }

    /// Bytes that it holds on the device.
    pub fn bytes(&self) -> u64 {
        self.pictures.as_ref().map_or(0, |p| p.bytes)
    }

    /// Writes uniforms and makes room. Called before every other method of a frame.
    pub fn prepare(&mut self, gpu: &Gpu, frame: &Frame) {
        let size = [frame.size[0], frame.size[1]];
        if self.pictures.as_ref().is_none_or(|p| p.frame_size != size) {
            self.pictures = Some(Pictures::new(gpu, &self.settings, size));
        }
        gpu.queue.write_buffer(&self.params, 0, &self.settings.params(frame).bytes());
        if let Some(p) = &self.pictures {
            for (axis, buffer) in (0..).zip(&p.filter_params) {
                let params = self.settings.filter_params(self.settings.size(size), axis);
                gpu.queue.write_buffer(buffer, 0, &params.bytes());
            }
        }
    }

    /// View depth, and normals where they are made from it.
    pub fn encode_surfaces(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, input: &OcclusionInput<'_>) {
        let Some(p) = &self.pictures else { return };
        let view = BindingResource::TextureView;
        let resources = vec![self.params.as_entire_binding(), view(input.depth), view(&p.view_depth.view)];
        self.surface.encode(gpu, encoder, resources, self.size(p));
    }

    /// The estimator.
    pub fn encode_estimate(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, input: &OcclusionInput<'_>) {
        let Some(p) = &self.pictures else { return };
        let view = BindingResource::TextureView;
        let resources = vec![
            self.params.as_entire_binding(),
            self.noise.as_entire_binding(),
            view(&p.view_depth.view),
            view(input.normal),
            view(&p.ambient[0].view),
        ];
        self.estimate.encode(gpu, encoder, resources, self.size(p));
    }

    /// What smooths the estimate.
    pub fn encode_filter(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
        let (Some(p), Some(filter)) = (&self.pictures, &self.filter) else { return };
        let view = BindingResource::TextureView;
        for axis in 0..2 {
            let resources = vec![
                p.filter_params[axis].as_entire_binding(),
                view(&p.ambient[axis].view),
                view(&p.ambient[1 - axis].view),
            ];
            filter.encode(gpu, encoder, resources, self.size(p));
        }
    }

    /// Ambient visibility and view depth, of the frame's size; none before the first frame.
    pub fn result(&self) -> Option<&Target> {
        self.pictures.as_ref().map(|p| &p.ambient[0])
    }

    /// Ambient visibility, 1 = unoccluded and where nothing is, row 0 at the top; empty before the first frame.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>> {
        let Some(target) = self.result() else { return Ok(Vec::new()) };
        let bytes = read_texture(gpu, &target.texture, 0, 0)?;
        Ok(bytes.as_chunks::<8>().0.iter().map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }

    fn size(&self, p: &Pictures) -> [u32; 2] {
        self.settings.size(p.frame_size)
    }
}

impl Pass {
    fn new(gpu: &Gpu, entry: &'static str, files: &[Source], bindings: &[wgpu::BindingType]) -> Self {
        let layout = gpu.layout(entry, ShaderStages::COMPUTE, bindings);
        let pipeline = gpu.compute(entry, assemble(files), entry, &[Some(&layout)]);
        Self { layout, pipeline }
    }

    /// A thread a texel.
    fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        resources: Vec<BindingResource<'_>>,
        [width, height]: [u32; 2],
    ) {
        let group = gpu.bind("occlusion", &self.layout, resources);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(width.div_ceil(PIXEL_GROUP), height.div_ceil(PIXEL_GROUP), 1);
    }
}

impl Pictures {
    fn new(gpu: &Gpu, settings: &OcclusionSettings, frame_size: [u32; 2]) -> Self {
        let [width, height] = settings.size(frame_size);
        let mut bytes = 0;
        let mut picture = |format: TextureFormat| {
            bytes +=
                u64::from(width) * u64::from(height) * u64::from(format.block_copy_size(None).unwrap_or(4));
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
        let view_depth = picture(TextureFormat::R32Float);
        let ambient = [picture(AMBIENT_FORMAT), picture(AMBIENT_FORMAT)];
        let filter_params = [0, 1].map(|axis| {
            gpu.uniform("occlusion::filter", &settings.filter_params([width, height], axis).bytes())
        });
        Self { frame_size, view_depth, ambient, filter_params, bytes }
    }
}

fn estimator(estimator: Estimator) -> &'static [Source] {
    match estimator {
        Estimator::Ssao => &[source::OCCLUSION_SSAO],
        Estimator::Hbao => &[source::OCCLUSION_MARCH, source::OCCLUSION_HBAO],
        Estimator::Alchemy => &[source::OCCLUSION_ALCHEMY],
        Estimator::Issao => &[source::OCCLUSION_ISSAO],
        Estimator::Gtao => &[source::OCCLUSION_MARCH, source::OCCLUSION_GTAO],
    }
}

fn size_of_params() -> usize {
    <adumbra_shaders::layout::OcclusionParams as adumbra_shaders::layout::GpuType>::SIZE
}
