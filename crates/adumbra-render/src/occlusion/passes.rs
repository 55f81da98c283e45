//! The GPU passes of ambient occlusion.

use adumbra_shaders::constants::PIXEL_GROUP;
use adumbra_shaders::layout::{
    Frame, GpuType, OcclusionFilterParams, OcclusionHistoryParams, OcclusionParams,
};
use adumbra_shaders::{Source, assemble, source};
use wgpu::{BindGroupLayout, BindingResource, ComputePipeline, ShaderStages, TextureFormat};

use super::estimator::Estimator;
use super::pictures::{AMBIENT_FORMAT, HISTORY_FORMAT, NORMAL_FORMAT, Pictures};
use super::settings::{Filter, Normals, OcclusionSettings, Term};
use super::taps::taps;
use crate::error::Result;
use crate::frame::Target;
use crate::gpu::{Gpu, binding};
use crate::readback::read_texture;

/// The inputs of the passes.
#[derive(Clone, Copy)]
pub struct OcclusionInput<'a> {
    /// The frame's uniform, equal to the one on the device.
    pub frame: &'a Frame,
    /// The camera's depth.
    pub depth: &'a wgpu::TextureView,
    /// World normals.
    pub normal: &'a wgpu::TextureView,
}

/// The pipelines of one ambient occlusion, with its textures.
pub struct OcclusionPasses {
    settings: OcclusionSettings,
    surface: Pass,
    normals: Option<Pass>,
    estimate: Pass,
    history: Option<Pass>,
    filter: Option<Pass>,
    up: Option<Pass>,
    params: wgpu::Buffer,
    noise: wgpu::Buffer,
    history_params: wgpu::Buffer,
    filter_params: [wgpu::Buffer; 2],
    pictures: Option<Pictures>,
    /// The current frame.
    now: Option<Frame>,
    /// The frame that the history belongs to.
    before: Option<Frame>,
    /// Index of the history texture that holds it.
    held: usize,
}

/// One compute pass.
struct Pass {
    layout: BindGroupLayout,
    pipeline: ComputePipeline,
}

impl OcclusionPasses {
    /// Creates the pipelines.
    pub fn new(gpu: &Gpu, settings: OcclusionSettings) -> Self {
        use binding::{DEPTH, LOADED, UNIFORM, written};
        let mut estimate = vec![source::OCCLUSION, source::OCCLUSION_PASS];
        estimate.extend(estimator(&settings));
        let filter = match settings.filter {
            Filter::None => None,
            Filter::Bilateral => Some("bilateral_line"),
            Filter::BilateralSquare => Some("bilateral_square"),
            Filter::Gauss => Some("gauss_line"),
        };
        let ambient = written(AMBIENT_FORMAT);
        let normals = || {
            let bindings = [UNIFORM, DEPTH, written(NORMAL_FORMAT)];
            Pass::new(gpu, "occlusion_normals", &[source::OCCLUSION, source::OCCLUSION_NORMALS], &bindings)
        };
        let history = || {
            let files = [source::OCCLUSION, source::OCCLUSION_HISTORY];
            let bindings = [UNIFORM, UNIFORM, LOADED, LOADED, LOADED, ambient, written(HISTORY_FORMAT)];
            Pass::new(gpu, "occlusion_history", &files, &bindings)
        };
        let up = || {
            let files = [source::VIEW_DEPTH, source::OCCLUSION_PLANE, source::OCCLUSION_UP];
            Pass::new(gpu, "occlusion_up", &files, &[UNIFORM, UNIFORM, DEPTH, LOADED, ambient])
        };
        let uniform = |label, bytes| gpu.uniform(label, &vec![0; bytes]);
        Self {
            surface: Pass::new(
                gpu,
                "occlusion_surface",
                &[source::VIEW_DEPTH, source::OCCLUSION_SURFACE],
                &[UNIFORM, DEPTH, written(TextureFormat::R32Float)],
            ),
            normals: (settings.normals == Normals::Depth).then(normals),
            estimate: Pass::new(gpu, "occlude", &estimate, &[UNIFORM, UNIFORM, LOADED, LOADED, ambient]),
            history: settings.reuse.then(history),
            filter: filter.map(|entry| {
                let files = [source::OCCLUSION_PLANE, source::OCCLUSION_FILTER];
                Pass::new(gpu, entry, &files, &[UNIFORM, LOADED, ambient])
            }),
            up: settings.half.then(up),
            params: uniform("occlusion::params", OcclusionParams::SIZE),
            noise: gpu.uniform("occlusion::noise", &taps(&settings).bytes()),
            history_params: uniform("occlusion::history", OcclusionHistoryParams::SIZE),
            filter_params: [0, 1].map(|_| uniform("occlusion::filter", OcclusionFilterParams::SIZE)),
            pictures: None,
            now: None,
            before: None,
            held: 0,
            settings,
        }
    }

    /// The settings that the passes were created with.
    pub fn settings(&self) -> &OcclusionSettings {
        &self.settings
    }

    /// Changes the numeric parameters for the same estimator and passes, and discards the history. Returns
    /// false, and does nothing, if the passes would differ.
    pub fn reshape(&mut self, gpu: &Gpu, settings: &OcclusionSettings) -> bool {
        let same = OcclusionSettings {
            shape: self.settings.shape,
            radius_world: self.settings.radius_world,
            ..*settings
        };
        if same != self.settings || settings.term() != self.settings.term() {
            return false;
        }
        self.settings = *settings;
        self.forget();
        gpu.queue.write_buffer(&self.noise, 0, &taps(settings).bytes());
        true
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.pictures.as_ref().map_or(0, |p| p.bytes)
    }

    /// Discards the history of previous frames, as after a camera cut.
    pub fn forget(&mut self) {
        self.before = None;
    }

    /// Writes uniforms and allocates textures. Call it before every other method of a frame. The others
    /// follow in the order in which they are declared here.
    pub fn prepare(&mut self, gpu: &Gpu, frame: &Frame) {
        let size = frame.size;
        if self.pictures.as_ref().is_none_or(|p| p.frame_size != size) {
            self.pictures = Some(Pictures::new(gpu, &self.settings, size));
            self.forget();
        }
        gpu.queue.write_buffer(&self.params, 0, &self.settings.params(frame).bytes());
        for (axis, buffer) in (0..).zip(&self.filter_params) {
            gpu.queue.write_buffer(buffer, 0, &self.settings.filter_params(frame, axis).bytes());
        }
        if self.history.is_some() {
            let params = self.settings.history_params(frame, self.before.as_ref());
            gpu.queue.write_buffer(&self.history_params, 0, &params.bytes());
        }
        self.now = Some(*frame);
    }

    /// Encodes view depth, and normals if they are computed from depth.
    pub fn encode_surfaces(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, input: &OcclusionInput<'_>) {
        let Some(p) = &self.pictures else { return };
        let view = BindingResource::TextureView;
        let resources = vec![self.params.as_entire_binding(), view(input.depth), view(&p.view_depth.view)];
        self.surface.encode(gpu, encoder, resources, self.size(p));
        if let (Some(pass), Some(normals)) = (&self.normals, &p.normals) {
            let resources = vec![self.params.as_entire_binding(), view(input.depth), view(&normals.view)];
            pass.encode(gpu, encoder, resources, self.size(p));
        }
    }

    /// Encodes the estimator.
    pub fn encode_estimate(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, input: &OcclusionInput<'_>) {
        let Some(p) = &self.pictures else { return };
        let view = BindingResource::TextureView;
        let resources = vec![
            self.params.as_entire_binding(),
            self.noise.as_entire_binding(),
            view(&p.view_depth.view),
            view(p.normals.as_ref().map_or(input.normal, |n| &n.view)),
            view(&p.ambient[0].view),
        ];
        self.estimate.encode(gpu, encoder, resources, self.size(p));
    }

    /// Whether previous frames are reused.
    pub(crate) fn has_history(&self) -> bool {
        self.history.is_some()
    }

    /// Encodes the mean with previous frames.
    pub fn encode_history(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        input: &OcclusionInput<'_>,
    ) {
        let (Some(p), Some(pass)) = (&self.pictures, &self.history) else { return };
        let Some(history) = &p.history else { return };
        let view = BindingResource::TextureView;
        let resources = vec![
            self.params.as_entire_binding(),
            self.history_params.as_entire_binding(),
            view(&p.ambient[0].view),
            view(p.normals.as_ref().map_or(input.normal, |n| &n.view)),
            view(&history[self.held].view),
            view(&p.ambient[1].view),
            view(&history[1 - self.held].view),
        ];
        pass.encode(gpu, encoder, resources, self.size(p));
        self.held = 1 - self.held;
        self.before = self.now;
    }

    /// Encodes the filter, and the upsampling to the frame's size.
    pub fn encode_filter(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, input: &OcclusionInput<'_>) {
        let Some(p) = &self.pictures else { return };
        let view = BindingResource::TextureView;
        if let Some(filter) = &self.filter {
            let axes = self.filter_params.iter().take(self.settings.filter_passes() as usize);
            for (axis, params) in axes.enumerate() {
                let from = (self.first() + axis) % 2;
                let resources = vec![
                    params.as_entire_binding(),
                    view(&p.ambient[from].view),
                    view(&p.ambient[1 - from].view),
                ];
                filter.encode(gpu, encoder, resources, self.size(p));
            }
        }
        if let (Some(up), Some(whole)) = (&self.up, &p.whole) {
            let resources = vec![
                self.params.as_entire_binding(),
                self.filter_params[0].as_entire_binding(),
                view(input.depth),
                view(&p.ambient[self.last()].view),
                view(&whole.view),
            ];
            up.encode(gpu, encoder, resources, p.frame_size);
        }
    }

    /// Ambient visibility and view depth, at the frame's size. `None` before the first frame.
    pub fn result(&self) -> Option<&Target> {
        self.pictures.as_ref().map(|p| p.whole.as_ref().unwrap_or(&p.ambient[self.last()]))
    }

    /// Reads back the ambient visibility, row 0 at the top. 1 = unoccluded, and also where there is no
    /// surface. Empty before the first frame.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>> {
        let Some(target) = self.result() else { return Ok(Vec::new()) };
        let bytes = read_texture(gpu, &target.texture, 0, 0)?;
        Ok(bytes.as_chunks::<8>().0.iter().map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }

    /// Index of the texture that the filter begins with.
    fn first(&self) -> usize {
        usize::from(self.history.is_some())
    }

    /// Index of the texture that the filter ends with.
    fn last(&self) -> usize {
        (self.first() + self.settings.filter_passes() as usize) % 2
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

    /// Encodes one thread per texel.
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

/// The WGSL files of the estimator.
fn estimator(settings: &OcclusionSettings) -> &'static [Source] {
    match settings.estimator {
        Estimator::Ssao => &[source::OCCLUSION_SSAO],
        Estimator::Hbao => &[source::OCCLUSION_MARCH, source::OCCLUSION_HBAO],
        Estimator::Alchemy => &[source::OCCLUSION_ALCHEMY],
        Estimator::Issao => match settings.term() {
            Term::Attenuated => &[source::OCCLUSION_ISSAO, source::OCCLUSION_ISSAO_TERM],
            Term::Falloff => &[source::OCCLUSION_ISSAO, source::OCCLUSION_ISSAO_FALLOFF],
            Term::Bare => &[source::OCCLUSION_ISSAO, source::OCCLUSION_ISSAO_BARE],
        },
        Estimator::Gtao => &[source::OCCLUSION_MARCH, source::OCCLUSION_GTAO],
    }
}
