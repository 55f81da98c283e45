//! The technique `hrsm`: a shadow map over the scene, merged where depth is smooth.
//!
//! Bind group 2: parameters, words, the same words by fours (see access/hybrid_compact.wgsl). The shadow map that it is made from, and room for the largest map of
//! its size, stay on the device while light or casters change; with `cache_static` they are given back once nothing does.

use adumbra_shaders::constants::HYBRID_ONE;
use adumbra_shaders::layout::{HybridParams, MapLayer};
use adumbra_shaders::{Source, source};
use wgpu::{BufferUsages, ShaderStages};

use super::build::{Builder, BuiltCounts};
use super::settings::{HybridSettings, MergeTest, PlaneUnits};
use super::twin::HybridTree;
use crate::error::Result;
use crate::gpu::{Gpu, binding};
use crate::maps::cascades::LayerFit;
use crate::maps::depth_pass::{DepthPass, DepthPassOptions};
use crate::maps::layers::Layer;
use crate::maps::textures::DepthTextures;
use crate::maps::{MapFilter, scene_fit};
use crate::readback::{read_buffer, read_depth};
use crate::technique::{Answer, FrameInput, Technique};

/// A hybrid-resolution shadow map on one device.
pub struct HybridMap {
    name: String,
    settings: HybridSettings,
    params: HybridParams,
    units: PlaneUnits,
    uniform: wgpu::Buffer,
    pass: DepthPass,
    layer: Layer,
    /// What a map is built with; none once the map is kept alone.
    working: Option<Working>,
    /// The map alone.
    kept: Option<Kept>,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    /// Where the map was last built, and of what.
    built: Option<Place>,
    /// To be built in this frame.
    stale: bool,
}

struct Working {
    depth: DepthTextures,
    builder: Builder,
}

struct Kept {
    words: wgpu::Buffer,
    counts: BuiltCounts,
}

#[derive(Clone, Copy, PartialEq)]
struct Place {
    fit: LayerFit,
    /// [`SceneBuffers::id`](crate::scene::SceneBuffers::id) of what stands still and, where there is anything, of what moves.
    casters: [Option<u64>; 2],
}

impl HybridMap {
    /// Makes the buffers and pipelines of these settings, which are taken to be in range.
    ///
    /// # Errors
    /// [`crate::RenderError::TooLarge`] for a size that the device does not take.
    pub fn new(gpu: &Gpu, name: &str, settings: HybridSettings) -> Result<Self> {
        let pass = DepthPass::new(gpu, options(&settings));
        let working = Working::new(gpu, &settings)?;
        let params = params(&settings);
        let uniform = gpu.uniform("hybrid::params", &params.bytes());
        let kinds = [binding::UNIFORM, binding::STORAGE, binding::STORAGE];
        let layout = gpu.layout("hybrid", ShaderStages::COMPUTE, &kinds);
        let group = look_up_group(gpu, &layout, &uniform, working.builder.words());
        Ok(Self {
            name: name.to_owned(),
            settings,
            params,
            units: PlaneUnits::new(settings.test, 1.0),
            uniform,
            layer: Layer::new(gpu, &pass),
            pass,
            working: Some(working),
            kept: None,
            layout,
            group,
            built: None,
            stale: true,
        })
    }

    /// What it was made from.
    pub fn settings(&self) -> &HybridSettings {
        &self.settings
    }

    /// The parameters of the last frame.
    pub fn params(&self) -> &HybridParams {
        &self.params
    }

    /// How much of it the last frame's map fills; waits for the device.
    ///
    /// # Errors
    /// What the device reports.
    pub fn counts(&self, gpu: &Gpu) -> Result<BuiltCounts> {
        match (&self.kept, &self.working) {
            (Some(kept), _) => Ok(kept.counts),
            (None, Some(working)) => working.builder.counts(gpu),
            (None, None) => Ok(BuiltCounts { words: 0, split: [0; 3] }),
        }
    }

    /// The last frame's map.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read(&self, gpu: &Gpu) -> Result<HybridTree> {
        let counts = self.counts(gpu)?;
        let words = match (&self.kept, &self.working) {
            (Some(kept), _) => read_buffer(gpu, &kept.words)?,
            (None, Some(working)) => read_buffer(gpu, working.builder.words())?,
            (None, None) => Vec::new(),
        };
        let words = words.as_chunks::<4>().0.iter().map(|b| u32::from_le_bytes(*b));
        Ok(HybridTree {
            start: self.settings.start,
            merges: self.settings.merges(),
            test: self.settings.test,
            precision: self.settings.depth,
            units: self.units,
            split: counts.split,
            words: words.take(counts.words as usize).collect(),
        })
    }

    /// The shadow map that the last frame's was made from, row by row; none where it is not kept.
    ///
    /// # Errors
    /// What the device reports.
    pub fn read_start(&self, gpu: &Gpu) -> Result<Option<Vec<f32>>> {
        let Some(working) = &self.working else { return Ok(None) };
        read_depth(gpu, &working.depth.all.texture, 0).map(Some)
    }

    /// Copies the map into a buffer of its size and drops what it was built with.
    fn keep(&mut self, gpu: &Gpu) -> Result<()> {
        let Some(working) = &self.working else { return Ok(()) };
        let counts = working.builder.counts(gpu)?;
        let words = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("hybrid::kept"),
            size: 4 * u64::from(counts.words.next_multiple_of(4)),
            usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.encoder("hybrid::keep");
        encoder.copy_buffer_to_buffer(working.builder.words(), 0, &words, 0, words.size());
        gpu.finish(encoder.finish())?;
        self.group = look_up_group(gpu, &self.layout, &self.uniform, &words);
        self.kept = Some(Kept { words, counts });
        self.working = None;
        Ok(())
    }
}

impl Working {
    fn new(gpu: &Gpu, settings: &HybridSettings) -> Result<Self> {
        let depth = DepthTextures::new(gpu, "hybrid::depth", settings.start, 1, options(settings))?;
        let builder = Builder::new(gpu, settings, &depth.all.view)?;
        Ok(Self { depth, builder })
    }
}

impl Technique for HybridMap {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn prepare(&mut self, input: &FrameInput<'_>) -> Result<()> {
        let margin = self.settings.filter.reach_texels() + self.settings.bias.normal_offset_texels;
        let fit = scene_fit(input, self.settings.start, margin)?;
        let casters = [Some(input.scene.id()), input.movers.map(|m| m.id())];
        let place = Place { fit, casters };
        self.stale = !self.settings.cache_static || self.built != Some(place);
        if self.stale {
            if self.working.is_none() {
                let working = Working::new(input.gpu, &self.settings)?;
                self.group = look_up_group(input.gpu, &self.layout, &self.uniform, working.builder.words());
                self.working = Some(working);
                self.kept = None;
            }
            self.layer.prepare(input, &fit, true, false);
        } else {
            self.keep(input.gpu)?;
        }
        self.units =
            PlaneUnits::new(self.settings.test, fit.texel_world / (fit.depth_world[1] - fit.depth_world[0]));
        if let Some(working) = &self.working {
            working.builder.write(input.gpu, self.units);
        }
        self.built = Some(place);
        self.params.layer = fit.layer(input.anchor_world);
        self.params.slope[0] = self.units.slope;
        input.gpu.queue.write_buffer(&self.uniform, 0, &self.params.bytes());
        Ok(())
    }

    fn encode_depth(&mut self, input: &FrameInput<'_>, encoder: &mut wgpu::CommandEncoder) {
        if let (true, Some(working)) = (self.stale, &self.working) {
            self.layer.encode(input, &self.pass, encoder, 0, &working.depth, None);
        }
    }

    fn encode_build(&mut self, _input: &FrameInput<'_>, encoder: &mut wgpu::CommandEncoder) {
        if let (true, Some(working)) = (self.stale, &self.working) {
            working.builder.encode(encoder);
        }
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        let leaf = match self.settings.test {
            MergeTest::Plane { .. } => source::HYBRID_PLANE,
            MergeTest::Paper => source::HYBRID_MEAN,
        };
        let mut files = vec![source::MAPS, leaf, source::HYBRID_COMPACT, source::HYBRID];
        match (answer, &self.settings.filter) {
            (Answer::Cascade, _) => return None,
            (Answer::Level, _) => files.push(source::HYBRID_LEVELS),
            (Answer::Visibility, MapFilter::Nearest) => {
                files.extend([source::HYBRID_NEAREST, source::HYBRID_MAP]);
            }
            (Answer::Visibility, _) => {
                files.extend([source::HYBRID_BOX, source::HYBRID_PCF, source::HYBRID_MAP]);
            }
        }
        Some(files)
    }

    fn layouts(&self) -> [Option<&wgpu::BindGroupLayout>; 2] {
        [None, Some(&self.layout)]
    }

    fn groups(&self) -> [Option<&wgpu::BindGroup>; 2] {
        [None, Some(&self.group)]
    }

    fn texel_world(&self, _view_depth: f32) -> Option<f64> {
        Some(f64::from(self.params.layer.scale[0]))
    }

    fn bytes(&self) -> u64 {
        let working = self.working.as_ref().map_or(0, |w| w.depth.bytes() + w.builder.bytes());
        let kept = self.kept.as_ref().map_or(0, |k| k.words.size());
        working + kept + self.layer.bytes() + self.uniform.size()
    }

    fn hybrid(&self) -> Option<&HybridMap> {
        Some(self)
    }

    fn notes(&self) -> Vec<String> {
        self.settings.notes()
    }
}

fn options(settings: &HybridSettings) -> DepthPassOptions {
    DepthPassOptions { format: settings.depth.format(), normals: false }
}

fn look_up_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    uniform: &wgpu::Buffer,
    words: &wgpu::Buffer,
) -> wgpu::BindGroup {
    let words = words.as_entire_binding();
    gpu.bind("hybrid", layout, vec![uniform.as_entire_binding(), words.clone(), words])
}

/// What does not change from frame to frame.
fn params(settings: &HybridSettings) -> HybridParams {
    let bias = &settings.bias;
    let widening = 1.0 + bias.filter_factor * (settings.filter.bias_width() - 1.0);
    let halves = u32::from(settings.depth.step() > 0.0);
    let bias = [bias.constant_texels, bias.slope_texels, bias.normal_offset_texels, widening];
    HybridParams {
        layer: MapLayer {
            u_from_relative: [0.0; 4],
            v_from_relative: [0.0; 4],
            depth_from_relative: [0.0; 4],
            scale: [1.0, 1.0, 0.0, 0.0],
        },
        bias: bias.map(|c| c as f32),
        counts: [settings.start, settings.merges(), settings.width(), halves],
        slope: [HYBRID_ONE as i32, 0, 0, 0],
        least_bias: [settings.depth.step() as f32, 0.0, 0.0, 0.0],
    }
}
