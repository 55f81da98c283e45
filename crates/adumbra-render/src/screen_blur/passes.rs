//! The GPU passes of the blur.

use adumbra_shaders::constants::PIXEL_GROUP;
use adumbra_shaders::{Source, assemble, source};
use wgpu::{BindGroupLayout, BindingResource, ComputePipeline, Features, ShaderStages, TextureUsages};

use super::settings::{BlurPass, BlurSettings, BlurStep};
use crate::frame::{FACTOR_FORMAT, Target};
use crate::gpu::{Gpu, binding};

/// Inputs and output of the passes.
#[derive(Clone, Copy)]
pub struct BlurInput<'a> {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// The frame's uniform.
    pub frame: &'a wgpu::Buffer,
    /// The camera's depth.
    pub depth: &'a wgpu::TextureView,
    /// World normals.
    pub normal: &'a wgpu::TextureView,
    /// The unblurred factor.
    pub factor: &'a wgpu::TextureView,
    /// The target of the result.
    pub filtered: &'a wgpu::TextureView,
}

/// The pipelines of one blur, with its intermediate textures.
pub struct BlurPasses {
    settings: BlurSettings,
    steps: Vec<StepPipeline>,
    sampler: wgpu::Sampler,
    scratch: Option<Scratch>,
}

struct StepPipeline {
    step: BlurStep,
    layout: BindGroupLayout,
    pipeline: ComputePipeline,
}

/// Resources for one picture size.
struct Scratch {
    size: [u32; 2],
    /// Uniform of each step.
    uniforms: Vec<wgpu::Buffer>,
    /// Output of each step but the last. Steps alternate between two textures per size.
    written: Vec<wgpu::TextureView>,
    bytes: u64,
}

impl BlurPasses {
    /// Creates the pipelines. If the device does not filter 32-bit floats, pairs are disabled, and the
    /// technique's notes say so.
    pub fn new(gpu: &Gpu, mut settings: BlurSettings) -> Self {
        settings.pairs &= gpu.has(Features::FLOAT32_FILTERABLE);
        let steps = settings.steps().into_iter().map(|step| {
            let layout = gpu.layout("blur", ShaderStages::COMPUTE, &bindings(step.pass));
            let (entry, files) = shader(step.pass);
            let pipeline = gpu.compute(entry, assemble(files), entry, &[Some(&layout)]);
            StepPipeline { step, layout, pipeline }
        });
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("blur::linear"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Self { settings, steps: steps.collect(), sampler, scratch: None }
    }

    /// The settings in effect. Pairs may be disabled although they were requested.
    pub fn settings(&self) -> &BlurSettings {
        &self.settings
    }

    /// Bytes of the intermediate textures.
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
            let usage = TextureUsages::STORAGE_BINDING | TextureUsages::TEXTURE_BINDING;
            Target::new(gpu, "blur::scratch", [width, height], FACTOR_FORMAT, usage).view
        };
        // By size, then alternating. A step never reads the texture that it writes.
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

/// The entry point and the files of its shader module.
fn shader(pass: BlurPass) -> (&'static str, &'static [Source]) {
    const BLIND: &[Source] = &[
        source::SURFACE,
        source::VIEW_DEPTH,
        source::FRAME,
        source::BLUR,
        source::BLUR_FACTOR,
        source::BLUR_PASS,
    ];
    const HALF: &[Source] = &[source::BLUR_FACTOR, source::BLUR_HALF];
    const EDGES: &[Source] = &edges(source::BLUR_EDGES);
    const HALF_EDGES: &[Source] = &edges(source::BLUR_HALF_EDGES);
    const fn edges(pass: Source) -> [Source; 7] {
        [
            source::SURFACE,
            source::VIEW_DEPTH,
            source::FRAME,
            source::BLUR,
            source::BLUR_FACTOR,
            source::BLUR_SURFACES,
            pass,
        ]
    }
    match pass {
        BlurPass::Dilate => ("dilate_line", BLIND),
        BlurPass::HalfDown => ("half_down", HALF),
        BlurPass::HalfDownEdges => ("half_down_edges", HALF_EDGES),
        BlurPass::LineTable => ("blur_line_table", BLIND),
        BlurPass::LineShader => ("blur_line_shader", BLIND),
        BlurPass::LinePairs => ("blur_line_pairs", &[source::BLUR_FACTOR, source::BLUR_PAIRS]),
        BlurPass::LineEdges => ("blur_line_edges", EDGES),
        BlurPass::SquareTable => ("blur_square_table", BLIND),
        BlurPass::SquareShader => ("blur_square_shader", BLIND),
        BlurPass::SquareEdges => ("blur_square_edges", EDGES),
        BlurPass::HalfUp => ("half_up", HALF),
        BlurPass::HalfUpEdges => ("half_up_edges", HALF_EDGES),
    }
}
