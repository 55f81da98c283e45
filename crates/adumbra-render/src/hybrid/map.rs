//! The technique `hrsm`: a shadow map over the scene, merged where depth is smooth.
//!
//! Bind group 2 holds the parameters, then either the map's words and the same words in groups of four, or
//! texels and links (see access/hybrid_*.wgsl). The source shadow map, and buffers for the largest map of its
//! size, stay on the device while the light or the casters change. With `cache_static` they are freed once
//! nothing changes.

use std::any::Any;

use adumbra_shaders::layout::{HybridParams, MapLayer};
use adumbra_shaders::{Source, source};
use wgpu::ShaderStages;

use super::build::{HybridMapBuilder, Pipelines};
use super::settings::{HybridLayout, HybridSettings, PlaneUnits};
use super::stored::{BuiltCounts, Stored};
use super::twin::{HybridPaper, HybridTree, MergeSettings};
use crate::error::Result;
use crate::gpu::{Gpu, binding};
use crate::maps::cascades::LayerFit;
use crate::maps::depth_pass::{DepthPass, DepthPassOptions};
use crate::maps::layers::Layer;
use crate::maps::textures::DepthTextures;
use crate::maps::{DepthPrecision, MapFilter, scene_fit};
use crate::readback::{read_depth, read_texture};
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
    pipelines: Pipelines,
    held: Held,
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    /// The fit and casters of the last built map.
    built: Option<MapInputs>,
    /// Whether the map must be built in this frame.
    stale: bool,
}

/// The resources on the device.
enum Held {
    /// A map with everything needed to build it.
    Working(Box<Working>),
    /// Only the map.
    Kept { stored: Stored, counts: BuiltCounts },
}

struct Working {
    depth: DepthTextures,
    builder: HybridMapBuilder,
}

#[derive(Clone, Copy, PartialEq)]
struct MapInputs {
    fit: LayerFit,
    /// [`SceneBuffers::id`](crate::scene::SceneBuffers::id) of the static casters and, if there are any, of
    /// the moving ones.
    casters: [Option<u64>; 2],
}

impl HybridMap {
    /// Creates the buffers and pipelines for these settings.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if the settings are out of range, and
    /// [`crate::RenderError::TooLarge`] if the device does not support the size.
    pub fn new(gpu: &Gpu, name: &str, settings: HybridSettings) -> Result<Self> {
        settings.check()?;
        let pass = DepthPass::new(gpu, options(&settings));
        let pipelines = Pipelines::new(gpu, &settings);
        let working = Working::new(gpu, &settings, &pipelines)?;
        let params = params(&settings);
        let uniform = gpu.uniform("hybrid::params", &params.bytes());
        let kinds = [binding::UNIFORM, binding::STORAGE, binding::STORAGE];
        let layout = gpu.layout("hybrid", ShaderStages::COMPUTE, &kinds);
        let group = look_up_group(gpu, &layout, &uniform, working.builder.stored());
        Ok(Self {
            name: name.to_owned(),
            settings,
            params,
            units: PlaneUnits::new(settings.test, 1.0),
            uniform,
            layer: Layer::new(gpu, &pass),
            pass,
            pipelines,
            held: Held::Working(Box::new(working)),
            layout,
            group,
            built: None,
            stale: true,
        })
    }

    /// The settings that the map was created with.
    pub fn settings(&self) -> &HybridSettings {
        &self.settings
    }

    /// The parameters of the last frame.
    pub fn params(&self) -> &HybridParams {
        &self.params
    }

    /// Returns how much memory the last frame's map fills. Waits for the device.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn counts(&self, gpu: &Gpu) -> Result<BuiltCounts> {
        match &self.held {
            Held::Working(working) => working.builder.counts(gpu),
            Held::Kept { counts, .. } => Ok(*counts),
        }
    }

    fn stored(&self) -> &Stored {
        match &self.held {
            Held::Working(working) => working.builder.stored(),
            Held::Kept { stored, .. } => stored,
        }
    }

    fn working(&self) -> Option<&Working> {
        match &self.held {
            Held::Working(working) => Some(working),
            Held::Kept { .. } => None,
        }
    }

    fn merge_settings(&self) -> MergeSettings {
        let s = &self.settings;
        MergeSettings { merges: s.merges(), test: s.test, precision: s.depth, units: self.units }
    }

    /// Reads back the last frame's map. A map in the paper's layout is converted to the compact one.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn read(&self, gpu: &Gpu) -> Result<HybridTree> {
        if let Some(paper) = self.read_paper(gpu)? {
            return Ok(paper.compact());
        }
        let counts = self.counts(gpu)?;
        let [mut words, _] = self.stored().read(gpu)?;
        words.truncate(counts.words as usize);
        Ok(HybridTree {
            start: self.settings.start,
            settings: self.merge_settings(),
            split: counts.split,
            words,
        })
    }

    /// Reads back the last frame's map as the paper's layout stores it. `None` for the compact layout.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn read_paper(&self, gpu: &Gpu) -> Result<Option<HybridPaper>> {
        if self.settings.layout != HybridLayout::Paper {
            return Ok(None);
        }
        let counts = self.counts(gpu)?;
        let [texels, links] = self.stored().read(gpu)?;
        let listed = 4 * counts.split.iter().sum::<u32>() as usize;
        Ok(Some(HybridPaper {
            start: self.settings.start,
            settings: self.merge_settings(),
            split: counts.split,
            texels: texels.as_chunks().0.iter().take(counts.texels as usize).copied().collect(),
            links: links.as_chunks().0.iter().take(listed).copied().collect(),
        }))
    }

    /// Reads back the shadow map that the last frame's map was built from, row by row. `None` if it was
    /// freed.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn read_start(&self, gpu: &Gpu) -> Result<Option<Vec<f32>>> {
        let Some(working) = self.working() else { return Ok(None) };
        read_depth(gpu, &working.depth.all.texture, 0).map(Some)
    }

    /// Reads back the normals of [`HybridMap::read_start`], two bytes each ([`crate::octahedral`]). `None` if
    /// the layout has no normals or they were freed.
    ///
    /// # Errors
    /// Returns any error that the device reports.
    pub fn read_start_normals(&self, gpu: &Gpu) -> Result<Option<Vec<[u8; 2]>>> {
        let normals = self.working().and_then(|w| w.depth.normals.as_ref());
        let Some((all, _)) = normals else { return Ok(None) };
        Ok(Some(read_texture(gpu, &all.texture, 0, 0)?.as_chunks().0.to_vec()))
    }

    /// Copies the map into buffers of exactly its size and frees what it was built with.
    fn keep(&mut self, gpu: &Gpu) -> Result<()> {
        let Some(working) = self.working() else { return Ok(()) };
        working.builder.check(gpu)?;
        let counts = working.builder.counts(gpu)?;
        let stored = working.builder.stored().kept(gpu, &counts)?;
        self.hold(gpu, Held::Kept { stored, counts });
        Ok(())
    }

    fn hold(&mut self, gpu: &Gpu, held: Held) {
        self.held = held;
        self.group = look_up_group(gpu, &self.layout, &self.uniform, self.stored());
    }
}

impl Working {
    fn new(gpu: &Gpu, settings: &HybridSettings, pipelines: &Pipelines) -> Result<Self> {
        let depth = DepthTextures::new(gpu, "hybrid::depth", settings.start, 1, options(settings))?;
        let normals = depth.normals.as_ref().map(|(all, _)| &all.view);
        let builder = HybridMapBuilder::with_pipelines(gpu, settings, pipelines, &depth.all.view, normals)?;
        Ok(Self { depth, builder })
    }
}

impl dyn Technique + '_ {
    /// Returns the technique's hybrid map, if it has one, for reading back.
    pub fn hybrid(&self) -> Option<&HybridMap> {
        self.readable()?.downcast_ref()
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
        let place = MapInputs { fit, casters };
        self.stale = !self.settings.cache_static || self.built != Some(place);
        if self.stale {
            if self.working().is_none() {
                let working = Working::new(input.gpu, &self.settings, &self.pipelines)?;
                self.hold(input.gpu, Held::Working(Box::new(working)));
            }
            self.layer.prepare(input, &fit, true, false);
        } else {
            self.keep(input.gpu)?;
        }
        self.units =
            PlaneUnits::new(self.settings.test, fit.texel_world / (fit.depth_world[1] - fit.depth_world[0]));
        if let Some(working) = self.working() {
            working.builder.write(input.gpu, self.units);
        }
        self.built = Some(place);
        self.params.layer = fit.layer(input.anchor_world);
        self.params.slope_unit = self.units.slope;
        input.gpu.queue.write_buffer(&self.uniform, 0, &self.params.bytes());
        Ok(())
    }

    fn encode_depth(&mut self, input: &FrameInput<'_>, encoder: &mut wgpu::CommandEncoder) {
        if let (true, Held::Working(working)) = (self.stale, &self.held) {
            self.layer.encode(input, &self.pass, encoder, 0, &working.depth, None);
        }
    }

    fn encode_build(&mut self, _input: &FrameInput<'_>, encoder: &mut wgpu::CommandEncoder) {
        if let (true, Some(working)) = (self.stale, self.working()) {
            working.builder.encode(encoder);
        }
    }

    fn check(&self, gpu: &Gpu) -> Result<()> {
        match self.working() {
            Some(working) if self.stale => working.builder.check(gpu),
            _ => Ok(()),
        }
    }

    fn sources(&self, answer: Answer) -> Option<Vec<Source>> {
        let access = match self.settings.layout {
            HybridLayout::Compact => source::HYBRID_COMPACT,
            HybridLayout::Paper => source::HYBRID_PAPER,
        };
        let mut files =
            vec![source::MAP_LAYER, source::MAPS, self.settings.test.leaf(), access, source::HYBRID];
        match (answer, &self.settings.filter) {
            (Answer::Cascade | Answer::Voxel | Answer::Resident, _) => return None,
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
        Some(f64::from(self.params.layer.texel_world))
    }

    fn bytes(&self) -> u64 {
        let held = match &self.held {
            Held::Working(working) => working.depth.bytes() + working.builder.bytes(),
            Held::Kept { stored, .. } => stored.bytes(),
        };
        held + self.layer.bytes() + self.uniform.size()
    }

    fn readable(&self) -> Option<&dyn Any> {
        Some(self)
    }

    fn notes(&self) -> Vec<String> {
        self.settings.notes()
    }
}

fn options(settings: &HybridSettings) -> DepthPassOptions {
    let normals = settings.layout == HybridLayout::Paper;
    DepthPassOptions { format: settings.depth.format(), normals }
}

fn look_up_group(
    gpu: &Gpu,
    layout: &wgpu::BindGroupLayout,
    uniform: &wgpu::Buffer,
    stored: &Stored,
) -> wgpu::BindGroup {
    let [first, second] = stored.bindings();
    gpu.bind("hybrid", layout, vec![uniform.as_entire_binding(), first, second])
}

/// Returns the parameters. Those that change from frame to frame get placeholders.
fn params(settings: &HybridSettings) -> HybridParams {
    HybridParams {
        layer: MapLayer::EMPTY,
        bias: settings.bias.uniform(&settings.filter),
        start_texels: settings.start,
        merges: settings.merges(),
        filter_width: settings.width(),
        has_16_bit_depth: u32::from(settings.depth == DepthPrecision::Bits16),
        slope_unit: 1,
        min_bias_depth: settings.depth.min_bias_depth() as f32,
    }
}
