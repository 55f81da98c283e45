//! Merges a shadow map level by level. Same stems as passes/hybrid_*.wgsl.
//!
//! | pass of a level | reads | writes |
//! |---|---|---|
//! | merge (sweep or blocks) | depth, the level before | the level's words, a count a section |
//! | scan | counts | where each section's children begin |
//! | place | both levels, depth | children, the coarsest level |
//!
//! No pass waits for the CPU. The map is held at its largest until [`Builder::used_words`] is asked for.

use adumbra_shaders::constants::{HYBRID_SECTION, LIST_GROUP, PIXEL_GROUP};
use adumbra_shaders::layout::HybridLevel;
use adumbra_shaders::{assemble, source};
use wgpu::{BindingResource, BufferUsages, ShaderStages};

use super::settings::{BuildKind, HybridSettings, MergeTest, PlaneUnits};
use crate::error::{RenderError, Result};
use crate::gpu::{Gpu, binding};
use crate::maps::DepthPrecision;
use crate::readback::read_buffer;

/// Words before the sections in the buffer of counts.
const SECTIONS: u64 = 4;

/// What does not fit into one storage binding.
const MEND: &str = "give a smaller START";

/// The passes that build one map, with their buffers.
pub struct Builder {
    settings: HybridSettings,
    merge: wgpu::ComputePipeline,
    scan: wgpu::ComputePipeline,
    place: wgpu::ComputePipeline,
    levels: Vec<(wgpu::Buffer, wgpu::BindGroup)>,
    scratch: wgpu::Buffer,
    counts: wgpu::Buffer,
    words: wgpu::Buffer,
}

/// Blocks that did not merge, and the words that the map takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltCounts {
    /// Words in use.
    pub words: u32,
    /// By level, from 1.
    pub split: [u32; 3],
}

impl Builder {
    /// Buffers and pipelines for maps of these settings, made from `depth`: a `texture_depth_2d_array` of one layer with
    /// `settings.start` texels a side.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] where the device binds less than the largest map of this size.
    pub fn new(gpu: &Gpu, settings: &HybridSettings, depth: &wgpu::TextureView) -> Result<Self> {
        let texels: Vec<u64> =
            (0..=settings.merges()).map(|k| u64::from(settings.start >> k).pow(2)).collect();
        let target = u64::from(settings.target).pow(2);
        let finest = texels[0] / if settings.depth == DepthPrecision::Bits16 { 2 } else { 1 };
        let between: u64 = texels[1..texels.len() - 1].iter().sum();
        let largest = 4 * (target + finest + between).next_multiple_of(4);
        if largest > gpu.max_binding_bytes {
            return Err(RenderError::TooLarge {
                what: format!("a hybrid shadow map from {} texels a side", settings.start),
                bytes: largest,
                limit: gpu.max_binding_bytes,
                mend: MEND,
            });
        }
        let side = settings.start / 2;
        let sections = u64::from(side) * u64::from(side.div_ceil(HYBRID_SECTION));
        let storage = |label, words: u64| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 4 * words,
                usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let scratch = storage("hybrid::levels", texels[1..].iter().sum());
        let counts = storage("hybrid::counts", SECTIONS + sections);
        let words = storage("hybrid::words", largest / 4);
        let out = binding::STORAGE_OUT;
        let kinds = [binding::UNIFORM, binding::DEPTH_ARRAY, out, out, out];
        let layout = gpu.layout("hybrid_build", ShaderStages::COMPUTE, &kinds);
        let levels = (0..settings.merges()).map(|_| {
            let uniform = gpu.uniform("hybrid::level", &[0; 48]);
            let resources = vec![
                uniform.as_entire_binding(),
                BindingResource::TextureView(depth),
                scratch.as_entire_binding(),
                counts.as_entire_binding(),
                words.as_entire_binding(),
            ];
            let group = gpu.bind("hybrid_build", &layout, resources);
            (uniform, group)
        });
        let (leaf, test) = match settings.test {
            MergeTest::Plane { .. } => (source::HYBRID_PLANE, source::HYBRID_MERGE_PLANE),
            MergeTest::Paper => (source::HYBRID_MEAN, source::HYBRID_MERGE_MEAN),
        };
        let (pass, entry) = match settings.build {
            BuildKind::Sweep => (source::HYBRID_SWEEP, "hybrid_sweep"),
            BuildKind::Blocks => (source::HYBRID_BLOCKS, "hybrid_blocks"),
        };
        let groups = [Some(&layout)];
        let common = source::HYBRID_BUILD;
        let built = Self {
            settings: *settings,
            merge: gpu.compute(entry, assemble(&[leaf, common, test, pass]), entry, &groups),
            scan: gpu.compute(
                "hybrid_scan",
                assemble(&[common, source::HYBRID_SCAN]),
                "hybrid_scan",
                &groups,
            ),
            place: gpu.compute(
                "hybrid_place",
                assemble(&[common, source::HYBRID_PLACE]),
                "hybrid_place",
                &groups,
            ),
            levels: levels.collect(),
            scratch,
            counts,
            words,
        };
        gpu.check()?;
        Ok(built)
    }

    /// Sets what planes are measured in.
    pub fn write(&self, gpu: &Gpu, units: PlaneUnits) {
        let halves = self.settings.depth == DepthPrecision::Bits16;
        let (mut before, mut first) = (0, 0);
        for (made, (uniform, _)) in (1..).zip(&self.levels) {
            let side = self.settings.start >> made;
            let level = HybridLevel {
                counts: [self.settings.start, made, side, self.settings.merges()],
                places: [before, first, if halves && made == 1 { 2 } else { 4 }, u32::from(halves)],
                plane: [units.slope, units.tolerance, 0, 0],
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
            pass.set_pipeline(&self.merge);
            match self.settings.build {
                BuildKind::Sweep => pass.dispatch_workgroups(side.div_ceil(LIST_GROUP), 1, 1),
                BuildKind::Blocks => pass.dispatch_workgroups(side.div_ceil(HYBRID_SECTION), side, 1),
            }
            pass.set_pipeline(&self.scan);
            pass.dispatch_workgroups(1, 1, 1);
            pass.set_pipeline(&self.place);
            pass.dispatch_workgroups(side.div_ceil(PIXEL_GROUP), side.div_ceil(PIXEL_GROUP), 1);
        }
    }

    /// The map.
    pub fn words(&self) -> &wgpu::Buffer {
        &self.words
    }

    /// How much of the map the last build filled; waits for it.
    ///
    /// # Errors
    /// What the device reports.
    pub fn counts(&self, gpu: &Gpu) -> Result<BuiltCounts> {
        let mut encoder = gpu.encoder("hybrid::counts");
        let copy = gpu.buffer("hybrid::counts", &[0; 4 * SECTIONS as usize], BufferUsages::COPY_SRC);
        encoder.copy_buffer_to_buffer(&self.counts, 0, &copy, 0, 4 * SECTIONS);
        gpu.finish(encoder.finish())?;
        let bytes = read_buffer(gpu, &copy)?;
        let at = |i: usize| bytes.as_chunks::<4>().0.get(i).map_or(0, |b| u32::from_le_bytes(*b));
        let merges = self.settings.merges() as usize;
        Ok(BuiltCounts {
            words: at(0),
            split: std::array::from_fn(|k| if k < merges { at(k + 1) } else { 0 }),
        })
    }

    /// Bytes on the GPU, the map's largest size among them.
    pub fn bytes(&self) -> u64 {
        self.scratch.size() + self.counts.size() + self.words.size()
    }
}
