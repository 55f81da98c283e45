//! The passes on a device.

use adumbra_shaders::constants::PIXEL_GROUP;
use adumbra_shaders::layout::{
    Frame, GpuType, OcclusionFilterParams, OcclusionHistoryParams, OcclusionParams,
};
use adumbra_shaders::{Source, assemble, source};
use wgpu::{BindGroupLayout, BindingResource, ComputePipeline, ShaderStages, TextureFormat};

use super::estimator::Estimator;
use super::pictures::{HISTORY_FORMAT, NORMAL_FORMAT, Pictures};
use super::settings::{Filter, Normals, OcclusionSettings, Term};
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
    /// The frame being made.
    now: Option<Frame>,
    /// The frame that the history is of, and which of the two holds it.
    before: Option<Frame>,
    held: usize,
}

/// One pipeline.
struct Pass {
    layout: BindGroupLayout,
    pipeline: ComputePipeline,
}

impl OcclusionPasses {
    /// Builds the pipelines.
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
            Pass::new(gpu, "occlusion_normals", &[source::OCCLUSION_NORMALS], &bindings)
        };
        let history = || {
            let files = [source::OCCLUSION, source::OCCLUSION_HISTORY];
            let bindings = [UNIFORM, UNIFORM, LOADED, LOADED, LOADED, ambient, written(HISTORY_FORMAT)];
            Pass::new(gpu, "occlusion_history", &files, &bindings)
        };
        let up = || {
            let files = [source::OCCLUSION_PLANE, source::OCCLUSION_UP];
            Pass::new(gpu, "occlusion_up", &files, &[UNIFORM, UNIFORM, DEPTH, LOADED, ambient])
        };
        let uniform = |label, bytes| gpu.uniform(label, &vec![0; bytes]);
        Self {
            surface: Pass::new(
                gpu,
                "occlusion_surface",
                &[source::OCCLUSION_SURFACE],
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

    /// What it was made for.
    pub fn settings(&self) -> &OcclusionSettings {
        &self.settings
    }

    /// Other numbers for the same estimator and the same passes, without what is known of frames before; false, and nothing
    /// done, where passes would differ.
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

    /// Bytes that it holds on the device.
    pub fn bytes(&self) -> u64 {
        self.pictures.as_ref().map_or(0, |p| p.bytes)
    }

    /// Drops what is known of the frames before, as after a cut to another camera.
    pub fn forget(&mut self) {
        self.before = None;
    }

    /// Writes uniforms and makes room. Called before every other method of a frame; those follow in the order in which they
    /// stand here.
    pub fn prepare(&mut self, gpu: &Gpu, frame: &Frame) {
        let size = [frame.size[0], frame.size[1]];
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

    /// View depth, and normals where they are made from it.
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

    /// The estimator.
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

    /// Whether frames before count.
    pub fn has_history(&self) -> bool {
        self.history.is_some()
    }

    /// The mean with the frames before.
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

    /// What smooths the estimate, and brings it to the frame's size.
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

    /// Ambient visibility and view depth, of the frame's size; none before the first frame.
    pub fn result(&self) -> Option<&Target> {
        self.pictures.as_ref().map(|p| p.whole.as_ref().unwrap_or(&p.ambient[self.last()]))
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

    /// Which picture the filter begins with.
    fn first(&self) -> usize {
        usize::from(self.history.is_some())
    }

    /// Which picture it ends with.
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

/// The files that say what the pass asks.
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
