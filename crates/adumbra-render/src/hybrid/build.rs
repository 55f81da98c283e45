//! Merges a shadow map level by level. Same stems as passes/hybrid_*.wgsl.
//!
//! | pass of a level | reads | writes |
//! |---|---|---|
//! | merge (sweep or blocks) | depth, the level before | the level's words, a count a section |
//! | scan | counts | where each section's children begin |
//! | place | both levels, depth, in the paper's layout normals | children, the coarsest level |
//!
//! No pass waits for the CPU, so there is room for the largest map, or as much of it as the device binds; [`Builder::counts`] says how
//! much is in use. Where room runs out a block is taken as without a caster, and [`Builder::check`] says so.

use adumbra_shaders::constants::{
    HYBRID_FIRST_SECTION, HYBRID_LAST_DEPTH, HYBRID_SECTION, LIST_GROUP, PIXEL_GROUP,
};
use adumbra_shaders::layout::HybridLevel;
use adumbra_shaders::{assemble, source};
use wgpu::{BindingResource, BufferUsages, ShaderStages};

use super::place::{PlaceGroup, PlacePipeline};
use super::settings::{BuildKind, HybridLayout, HybridSettings, MergeTest, PlaneUnits};
use super::stored::{Stored, buffer, check_binding, too_large};
use crate::error::Result;
use crate::gpu::{Gpu, binding};
use crate::maps::DepthPrecision;
use crate::readback::read_buffer;

/// The pipelines of maps of the same settings.
#[derive(Clone)]
pub(super) struct Pipelines {
    layout: wgpu::BindGroupLayout,
    merge: wgpu::ComputePipeline,
    scan: wgpu::ComputePipeline,
    place: PlacePipeline,
}

/// The passes that build one map, with their buffers.
pub struct Builder {
    settings: HybridSettings,
    pipelines: Pipelines,
    levels: Vec<(wgpu::Buffer, wgpu::BindGroup)>,
    place: PlaceGroup,
    scratch: wgpu::Buffer,
    counts: wgpu::Buffer,
    stored: Stored,
}

/// Blocks that did not merge, and what the map takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltCounts {
    /// 32-bit words in use: of the compact layout its words, of the paper's four a texel and two a link.
    pub words: u32,
    /// Texels in use: the coarsest, and four a block that did not merge.
    pub texels: u32,
    /// By level, from 1.
    pub split: [u32; 3],
}

impl Pipelines {
    pub(super) fn new(gpu: &Gpu, settings: &HybridSettings) -> Self {
        let out = binding::STORAGE_OUT;
        let kinds = [binding::UNIFORM, binding::DEPTH_ARRAY, out, out];
        let layout = gpu.layout("hybrid_build", ShaderStages::COMPUTE, &kinds);
        let test = match settings.test {
            MergeTest::Plane { .. } => source::HYBRID_MERGE_PLANE,
            MergeTest::Paper => source::HYBRID_MERGE_MEAN,
        };
        let (pass, entry) = match settings.build {
            BuildKind::Sweep => (source::HYBRID_SWEEP, "hybrid_sweep"),
            BuildKind::Blocks => (source::HYBRID_BLOCKS, "hybrid_blocks"),
        };
        let common = source::HYBRID_BUILD;
        let pipeline = |entry, files: &[_]| gpu.compute(entry, assemble(files), entry, &[Some(&layout)]);
        Self {
            merge: pipeline(entry, &[settings.test.leaf(), common, test, pass]),
            scan: pipeline("hybrid_scan", &[common, source::HYBRID_SCAN]),
            place: PlacePipeline::new(gpu, settings, &layout),
            layout,
        }
    }
}

impl Builder {
    /// Buffers and pipelines for maps of these settings, made from `depth`: a `texture_depth_2d_array` of one layer with
    /// `settings.start` texels a side. Of the compact layout; see [`Builder::with_normals`].
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for settings out of range, [`crate::RenderError::TooLarge`] where the device binds less than
    /// the levels of this size.
    pub fn new(gpu: &Gpu, settings: &HybridSettings, depth: &wgpu::TextureView) -> Result<Self> {
        Self::with_normals(gpu, settings, depth, None)
    }

    /// The same of either layout. The paper's takes `normals` beside depth: a `texture_2d_array` of two bytes a texel, as
    /// core/octahedral.wgsl packs them.
    ///
    /// # Errors
    /// As [`Builder::new`], and [`crate::RenderError::DepthImage`] where normals are missing.
    pub fn with_normals(
        gpu: &Gpu,
        settings: &HybridSettings,
        depth: &wgpu::TextureView,
        normals: Option<&wgpu::TextureView>,
    ) -> Result<Self> {
        settings.check()?;
        Self::of(gpu, settings, &Pipelines::new(gpu, settings), depth, normals)
    }

    /// The same with pipelines that were made before, of settings that were checked.
    pub(super) fn of(
        gpu: &Gpu,
        settings: &HybridSettings,
        pipelines: &Pipelines,
        depth: &wgpu::TextureView,
        normals: Option<&wgpu::TextureView>,
    ) -> Result<Self> {
        let blocks: u64 = (1..=settings.merges()).map(|k| u64::from(settings.start >> k).pow(2)).sum();
        check_binding(gpu, settings, 4 * blocks)?;
        let stored = Stored::largest(gpu, settings)?;
        let side = settings.start / 2;
        let sections = u64::from(side) * u64::from(side.div_ceil(HYBRID_SECTION));
        let scratch = buffer(gpu, "hybrid::levels", 4 * blocks);
        let counts = buffer(gpu, "hybrid::counts", 4 * (u64::from(HYBRID_FIRST_SECTION) + sections));
        let levels = (0..settings.merges()).map(|_| {
            let uniform = gpu.uniform("hybrid::level", &[0; 64]);
            let resources = vec![
                uniform.as_entire_binding(),
                BindingResource::TextureView(depth),
                scratch.as_entire_binding(),
                counts.as_entire_binding(),
            ];
            let group = gpu.bind("hybrid_build", &pipelines.layout, resources);
            (uniform, group)
        });
        let built = Self {
            settings: *settings,
            levels: levels.collect(),
            place: pipelines.place.group(gpu, &stored, blocks, normals)?,
            pipelines: pipelines.clone(),
            scratch,
            counts,
            stored,
        };
        gpu.check()?;
        Ok(built)
    }

    /// Sets what planes are measured in.
    pub fn write(&self, gpu: &Gpu, units: PlaneUnits) {
        let halves = self.settings.depth == DepthPrecision::Bits16;
        let pairs = halves && self.settings.layout == HybridLayout::Compact;
        let empty = match self.settings.test {
            MergeTest::Plane { .. } => (HYBRID_LAST_DEPTH as u32) << 14,
            MergeTest::Paper => 1.0_f32.to_bits(),
        };
        let (mut before, mut first) = (0, 0);
        for (made, (uniform, _)) in (1..).zip(&self.levels) {
            let side = self.settings.start >> made;
            let level = HybridLevel {
                counts: [self.settings.start, made, side, self.settings.merges()],
                places: [before, first, if pairs && made == 1 { 2 } else { 4 }, u32::from(halves)],
                plane: [units.slope, units.tolerance, 0, 0],
                room: [self.stored.room(), empty, 0, 0],
            };
            gpu.queue.write_buffer(uniform, 0, &level.bytes());
            (before, first) = (first, first + side * side);
        }
    }

    /// Builds the map from what the depth texture holds by then.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        for (made, (_, group)) in (1..).zip(&self.levels) {
            let side = self.settings.start >> made;
            pass.set_bind_group(0, group, &[]);
            pass.set_pipeline(&self.pipelines.merge);
            match self.settings.build {
                BuildKind::Sweep => pass.dispatch_workgroups(side.div_ceil(LIST_GROUP), 1, 1),
                BuildKind::Blocks => pass.dispatch_workgroups(side.div_ceil(HYBRID_SECTION), side, 1),
            }
            pass.set_pipeline(&self.pipelines.scan);
            pass.dispatch_workgroups(1, 1, 1);
            pass.set_pipeline(&self.pipelines.place.pipeline);
            pass.set_bind_group(1, &self.place.group, &[]);
            pass.dispatch_workgroups(side.div_ceil(PIXEL_GROUP), side.div_ceil(PIXEL_GROUP), 1);
        }
    }

    /// The map: words of the compact layout, texels of the paper's.
    pub fn words(&self) -> &wgpu::Buffer {
        match &self.stored {
            Stored::Compact { words } => words,
            Stored::Paper { texels, .. } => texels,
        }
    }

    /// The map in either layout.
    pub(super) fn stored(&self) -> &Stored {
        &self.stored
    }

    /// How much of the map the last build filled; waits for it.
    ///
    /// # Errors
    /// What the device reports.
    pub fn counts(&self, gpu: &Gpu) -> Result<BuiltCounts> {
        let mut encoder = gpu.encoder("hybrid::counts");
        let copy =
            gpu.buffer("hybrid::counts", &[0; 4 * HYBRID_FIRST_SECTION as usize], BufferUsages::COPY_SRC);
        encoder.copy_buffer_to_buffer(&self.counts, 0, &copy, 0, copy.size());
        gpu.finish(encoder.finish())?;
        let bytes = read_buffer(gpu, &copy)?;
        let at = |i: usize| bytes.as_chunks::<4>().0.get(i).map_or(0, |b| u32::from_le_bytes(*b));
        let merges = self.settings.merges() as usize;
        let split: [u32; 3] = std::array::from_fn(|k| if k < merges { at(k + 1) } else { 0 });
        let listed = 4 * split.iter().sum::<u32>();
        let texels = self.settings.target.pow(2) + listed;
        Ok(match self.settings.layout {
            HybridLayout::Compact => BuiltCounts { words: at(0), texels, split },
            HybridLayout::Paper => BuiltCounts { words: 4 * texels + 2 * listed, texels, split },
        })
    }

    /// Whether the last build found room for all of the map; waits for it where it may not have.
    ///
    /// # Errors
    /// [`crate::RenderError::TooLarge`], and what the device reports.
    pub fn check(&self, gpu: &Gpu) -> Result<()> {
        if !self.stored.may_run_out(&self.settings) {
            return Ok(());
        }
        let counts = self.counts(gpu)?;
        let (used, each) = match self.settings.layout {
            HybridLayout::Compact => (counts.words, 4),
            HybridLayout::Paper => (counts.texels, 16),
        };
        if used <= self.stored.room() {
            return Ok(());
        }
        Err(too_large(gpu, &self.settings, each * u64::from(used)))
    }

    /// Bytes on the GPU, the map's largest size among them.
    pub fn bytes(&self) -> u64 {
        self.scratch.size() + self.counts.size() + self.stored.bytes() + self.place.bytes()
    }
}
