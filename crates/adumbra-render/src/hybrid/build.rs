//! Builds a hybrid map by merging a shadow map level by level. Counterpart of passes/hybrid_*.wgsl.
//!
//! | pass of a level | reads | writes |
//! |---|---|---|
//! | merge (sweep or blocks) | depth, the next finer level | the level's words, a count per section |
//! | scan | counts | the offset at which each section's children begin |
//! | place | both levels, depth, and normals for the paper's layout | children, the coarsest level |
//!
//! No pass waits for the CPU, so the buffers are sized for the largest map, or as much of it as the device
//! can bind. [`HybridMapBuilder::counts`] returns how much is in use. If room runs out, a block is treated as
//! if it had no caster, and [`HybridMapBuilder::check`] reports it.

use adumbra_shaders::constants::{
    HYBRID_FIRST_SECTION, HYBRID_LAST_DEPTH, HYBRID_SECTION, LIST_GROUP, PIXEL_GROUP,
};
use adumbra_shaders::layout::{GpuType, HybridLevel};
use adumbra_shaders::{assemble, source};
use wgpu::{BindingResource, BufferUsages, ShaderStages};

use super::place::{PlaceGroup, PlacePipeline};
use super::settings::{BuildKind, HybridLayout, HybridSettings, MergeTest, PlaneUnits};
use super::stored::{BuiltCounts, Stored, buffer, check_binding, too_large};
use crate::error::Result;
use crate::gpu::{Gpu, binding};
use crate::maps::DepthPrecision;
use crate::readback::read_buffer;

/// The pipelines shared by maps of the same settings.
#[derive(Clone)]
pub(super) struct Pipelines {
    layout: wgpu::BindGroupLayout,
    merge: wgpu::ComputePipeline,
    scan: wgpu::ComputePipeline,
    place: PlacePipeline,
}

/// The passes that build one map, with their buffers.
pub struct HybridMapBuilder {
    settings: HybridSettings,
    pipelines: Pipelines,
    levels: Vec<(wgpu::Buffer, wgpu::BindGroup)>,
    place: PlaceGroup,
    scratch: wgpu::Buffer,
    counts: wgpu::Buffer,
    stored: Stored,
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

impl HybridMapBuilder {
    /// Creates the buffers and pipelines for compact maps of these settings, made from
    /// `depth`: a `texture_depth_2d_array` of one layer with `settings.start` texels per side. For the
    /// paper's layout see [`HybridMapBuilder::with_normals`].
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if the settings are out of range,
    /// [`crate::RenderError::TooLarge`] if the device cannot bind levels of this size, and
    /// [`crate::RenderError::DepthImage`] if the layout is the paper's, which needs normals.
    pub fn new(gpu: &Gpu, settings: &HybridSettings, depth: &wgpu::TextureView) -> Result<Self> {
        Self::with_normals(gpu, settings, depth, None)
    }

    /// Creates the buffers and pipelines for maps of either layout. The paper's also takes `normals`: a
    /// `texture_2d_array` of two bytes per texel, packed as in core/octahedral.wgsl.
    ///
    /// # Errors
    /// Returns the errors of [`HybridMapBuilder::new`]. [`crate::RenderError::DepthImage`] means that
    /// `normals` are missing.
    pub fn with_normals(
        gpu: &Gpu,
        settings: &HybridSettings,
        depth: &wgpu::TextureView,
        normals: Option<&wgpu::TextureView>,
    ) -> Result<Self> {
        settings.check()?;
        Self::with_pipelines(gpu, settings, &Pipelines::new(gpu, settings), depth, normals)
    }

    /// [`HybridMapBuilder::with_normals`] with existing pipelines and settings that have been checked.
    pub(super) fn with_pipelines(
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
            let uniform = gpu.uniform("hybrid::level", &[0; HybridLevel::SIZE]);
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

    /// Writes the uniforms of all levels, with `units` as the units of merged planes.
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
                start_texels: self.settings.start,
                number: made,
                side_texels: side,
                merges: self.settings.merges(),
                finer_offset: before,
                offset: first,
                split_size: if pairs && made == 1 { 2 } else { 4 },
                has_16_bit_depth: u32::from(halves),
                slope_unit: units.slope,
                twice_tolerance: units.tolerance,
                room: self.stored.room(),
                empty_word: empty,
            };
            gpu.queue.write_buffer(uniform, 0, &level.bytes());
            (before, first) = (first, first + side * side);
        }
    }

    /// Encodes the passes that build the map from the contents of the depth texture at that time.
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

    /// The map's buffer: words of the compact layout, texels of the paper's.
    pub fn words(&self) -> &wgpu::Buffer {
        match &self.stored {
            Stored::Compact { words } => words,
            Stored::Paper { texels, .. } => texels,
        }
    }

    /// The map's buffers in either layout.
    pub(super) fn stored(&self) -> &Stored {
        &self.stored
    }

    /// Returns how much of the map the last build filled. Waits for the build.
    ///
    /// # Errors
    /// Returns any error that the device reports.
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

    /// Checks that the last build had room for the whole map. Waits for the build if it may not have had.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::TooLarge`] if room ran out, and any error that the device reports.
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

    /// Bytes on the GPU, including the room for the largest map.
    pub fn bytes(&self) -> u64 {
        self.scratch.size() + self.counts.size() + self.stored.bytes() + self.place.bytes()
    }
}
