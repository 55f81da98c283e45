//! The blur's passes on a device.

use adumbra_shaders::constants::PIXEL_GROUP;
use adumbra_shaders::{Source, assemble, source};
use wgpu::{BindGroupLayout, BindingResource, ComputePipeline, Features, ShaderStages, TextureUsages};

use super::settings::{BlurPass, BlurSettings, BlurStep};
use crate::frame::FACTOR_FORMAT;
use crate::gpu::{Gpu, binding};

/// What the passes read and write.
#[derive(Clone, Copy)]
pub struct BlurInput<'a> {
    /// Pixels.
    pub size: [u32; 2],
    /// The frame's uniform.
    pub frame: &'a wgpu::Buffer,
    /// The camera's depth.
    pub depth: &'a wgpu::TextureView,
    /// World normals.
    pub normal: &'a wgpu::TextureView,
    /// The factor as looked up.
    pub factor: &'a wgpu::TextureView,
    /// Where the result goes.
    pub filtered: &'a wgpu::TextureView,
}

/// The pipelines of one blur, with its intermediate pictures.
pub struct BlurPasses {
    settings: BlurSettings,
    steps: Vec<Built>,
    sampler: wgpu::Sampler,
    scratch: Option<Scratch>,
}

struct Built {
    step: BlurStep,
    layout: BindGroupLayout,
    pipeline: ComputePipeline,
}

/// Made for one size of picture.
struct Scratch {
    size: [u32; 2],
    /// Of each step.
    uniforms: Vec<wgpu::Buffer>,
    /// What each step but the last writes: two pictures of a size take turns.
    written: Vec<wgpu::TextureView>,
    bytes: u64,
}

impl BlurPasses {
    /// Builds the pipelines. Without filtering of 32-bit floats, pairs are left out: the technique's notes say so.
    pub fn new(gpu: &Gpu, mut settings: BlurSettings) -> Self {
        settings.pairs &= gpu.has(Features::FLOAT32_FILTERABLE);
        let steps = settings.steps().into_iter().map(|step| {
            let layout = gpu.layout("blur", ShaderStages::COMPUTE, &bindings(step.pass));
            let (entry, files) = shader(step.pass);
            let pipeline = gpu.compute(entry, assemble(files), entry, &[Some(&layout)]);
            Built { step, layout, pipeline }
        });
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("blur::linear"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Self { settings, steps: steps.collect(), sampler, scratch: None }
    }

    /// What is done, which may be less than was asked for.
    pub fn settings(&self) -> &BlurSettings {
        &self.settings
    }

    /// Bytes of the intermediate pictures.
    pub fn bytes(&self) -> u64 {
        self.scratch.as_ref().map_or(0, |s| s.bytes)
    }

    /// Encodes every pass.
    pub fn encode(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, input: &BlurInput<'_>) {
        let scratch = match self.scratch.take() {
            Some(scratch) if scratch.size == input.size => scratch,
            _ => Scratch::new(gpu, &self.settings, input.size),
        };
        let mut from = input.factor;
        for (i, built) in self.steps.iter().enumerate() {
            let to = scratch.written.get(i).unwrap_or(input.filtered);
            let view = BindingResource::TextureView;
            let mut resources = vec![scratch.uniforms[i].as_entire_binding(), view(from), view(to)];
            if built.step.pass == BlurPass::LinePairs {
                resources.push(BindingResource::Sampler(&self.sampler));
            }
            if sees_surfaces(built.step.pass) {
                resources.extend([input.frame.as_entire_binding(), view(input.depth), view(input.normal)]);
            }
            if built.step.pass == BlurPass::HalfUpEdges {
                resources.push(view(input.factor));
            }
            let group = gpu.bind("blur", &built.layout, resources);
            let [_, half] = built.step.is_half(&self.settings);
            let [w, h] = if half { self.settings.size(input.size) } else { input.size };
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&built.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(w.div_ceil(PIXEL_GROUP), h.div_ceil(PIXEL_GROUP), 1);
            from = to;
        }
        self.scratch = Some(scratch);
    }
}

impl Scratch {
    fn new(gpu: &Gpu, settings: &BlurSettings, size: [u32; 2]) -> Self {
        let steps = settings.steps();
        let mut bytes = 0;
        let mut picture = |[width, height]: [u32; 2]| {
            bytes += u64::from(width) * u64::from(height) * 4;
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("blur::scratch"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: FACTOR_FORMAT,
                usage: TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        // By size, then by turn; a step never reads what it writes.
        let mut made: [[Option<wgpu::TextureView>; 2]; 2] = Default::default();
        let mut written = Vec::new();
        for (i, step) in steps.iter().enumerate().take(steps.len() - 1) {
            let [_, half] = step.is_half(settings);
            let of_size = if half { settings.size(size) } else { size };
            written.push(made[usize::from(half)][i % 2].get_or_insert_with(|| picture(of_size)).clone());
        }
        let uniform = |step: &BlurStep| gpu.uniform("blur::params", &settings.params(*step, size).bytes());
        Self { size, uniforms: steps.iter().map(uniform).collect(), written, bytes }
    }
}

fn sees_surfaces(pass: BlurPass) -> bool {
    use BlurPass::{HalfDownEdges, HalfUpEdges, LineEdges, SquareEdges};
    matches!(pass, HalfDownEdges | HalfUpEdges | LineEdges | SquareEdges)
}

fn bindings(pass: BlurPass) -> Vec<wgpu::BindingType> {
    let pairs = pass == BlurPass::LinePairs;
    let read = if pairs { binding::SAMPLED } else { binding::LOADED };
    let mut all = vec![binding::UNIFORM, read, binding::written(FACTOR_FORMAT)];
    if pairs {
        all.push(binding::SAMPLER);
    }
    if sees_surfaces(pass) {
        all.extend([binding::UNIFORM, binding::DEPTH, binding::LOADED]);
    }
    if pass == BlurPass::HalfUpEdges {
        all.push(binding::LOADED);
    }
    all
}

/// The entry point and the files of its module.
fn shader(pass: BlurPass) -> (&'static str, &'static [Source]) {
    const BLIND: &[Source] = &[source::SURFACE, source::FRAME, source::BLUR, source::BLUR_PASS];
    const EDGES: &[Source] = &[source::SURFACE, source::FRAME, source::BLUR, source::BLUR_EDGES];
    const HALF_EDGES: &[Source] = &[source::SURFACE, source::FRAME, source::BLUR, source::BLUR_HALF_EDGES];
    match pass {
        BlurPass::Dilate => ("dilate_line", BLIND),
        BlurPass::HalfDown => ("half_down", &[source::BLUR_HALF]),
        BlurPass::HalfDownEdges => ("half_down_edges", HALF_EDGES),
        BlurPass::LineTable => ("blur_line_table", BLIND),
        BlurPass::LineShader => ("blur_line_shader", BLIND),
        BlurPass::LinePairs => ("blur_line_pairs", &[source::BLUR_PAIRS]),
        BlurPass::LineEdges => ("blur_line_edges", EDGES),
        BlurPass::SquareTable => ("blur_square_table", BLIND),
        BlurPass::SquareShader => ("blur_square_shader", BLIND),
        BlurPass::SquareEdges => ("blur_square_edges", EDGES),
        BlurPass::HalfUp => ("half_up", &[source::BLUR_HALF]),
        BlurPass::HalfUpEdges => ("half_up_edges", HALF_EDGES),
    }
}
