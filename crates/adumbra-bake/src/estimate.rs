//! Forecasts the cost of a bake from a few of its root blocks.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use adumbra::file::HEADER_BYTES;
use adumbra_scene::Scene;

use crate::choose::Choice;
use crate::error::{Error, Result};
use crate::fast::descent::{DescentBuffers, build_root};
use crate::options::BakeOptions;
use crate::sink::depths::DepthsSink;
use crate::sink::limit::LimitSink;
use crate::sink::{BlockSink, Structure};

/// A forecast of a bake. Ranges are `[likely low, likely high]`.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Total number of root blocks.
    pub root_blocks: usize,
    /// Number of root blocks that were drawn for the forecast.
    pub sampled_root_blocks: usize,
    /// Wall-clock seconds on the current thread pool.
    pub seconds: [f64; 2],
    /// Size of the file in bytes.
    pub file_bytes: [u64; 2],
    /// Peak of the bytes that the bake would account for.
    pub memory_bytes: [u64; 2],
}

/// Number of root blocks drawn for a forecast.
const SAMPLES: usize = 48;
/// Factors from the forecast bytes to the likely least and most bytes of a bake. Measured: 0.61 to 1.45 on
/// generated and on real scenes at 1024 to 16384.
const SPREAD_OF_BYTES: [f64; 2] = [0.6, 1.5];

/// Draws a few root blocks of the bake for `options`, from the emptiest to the fullest, and extrapolates.
///
/// # Errors
/// Returns the errors of [`Bake::in_memory`](crate::Bake::in_memory). The memory limit applies to the
/// forecast itself, not to the bake that it predicts.
pub(crate) fn estimate(scene: &Scene, options: &BakeOptions, cancel: &AtomicBool) -> Result<Estimate> {
    let start = Instant::now();
    let plan = Choice::new(scene, options, cancel)?.plan(scene, 0)?;
    let planning_seconds = start.elapsed().as_secs_f64();
    let (level, [_, _, depth]) = (plan.root_blocks.root_level, plan.root_blocks.grid.size);
    let root_blocks = plan.root_blocks.count();
    let sampled = root_blocks.min(SAMPLES);
    let mut buffers = DescentBuffers::default();
    let mut build = |root_block: usize, sink: &DepthsSink| {
        let sink = LimitSink { limit: plan.switch_limit(), sink };
        build_root(&plan.root_blocks, root_block, &sink, &mut buffers, cancel)
    };
    // The blocks side by side, as if they were a row of the grid.
    let row = |blocks: usize| [(blocks as u32) << level, 1 << level, depth];
    let bytes = |sink: DepthsSink| Ok::<_, Error>(4 * sink.into_pages().tree()?.code().len() as u64);
    let merged = DepthsSink::in_memory(row(sampled), level, true);
    let mut separate_bytes = 0;
    let start = Instant::now();
    let fullness = |root_block| plan.root_blocks.casters.in_bin(root_block).len() as u64;
    for (number, root_block) in plan.root_blocks.sampled(sampled, fullness).enumerate() {
        let alone = DepthsSink::in_memory(row(1), level, true);
        alone.taken(0, build(root_block, &alone)?);
        merged.taken(number, build(root_block, &merged)?);
        let held_bytes = plan.scene_bytes + plan.worker_bytes + merged.memory_bytes() + alone.memory_bytes();
        plan.check_memory("the forecast", held_bytes)?;
        separate_bytes += bytes(alone)?;
    }
    // Each root block was built twice.
    let seconds = start.elapsed().as_secs_f64() / 2.0 * root_blocks as f64 / (sampled * plan.workers) as f64;
    let scale = root_blocks as f64 / sampled as f64;
    let [built_bytes, finish_bytes] =
        [merged.memory_bytes(), merged.finish_bytes()].map(|bytes| bytes as f64);
    let merged_bytes = bytes(merged)? as f64;
    // Upper bound: every root block adds as many bytes as the sampled ones. Lower bound: the sharing seen
    // among the samples continues over all root blocks.
    let sharing = merged_bytes / (separate_bytes as f64).max(1.0);
    let least = scale * sharing.powf(scale.log2().max(0.0)).max(0.25);
    let [less, more] = SPREAD_OF_BYTES;
    let scales = [less * least, more * scale];
    // The peak is either while root blocks are built, or after the last one.
    let memory_bytes = |scale: f64| {
        let building = plan.baking_bytes() as f64 + scale * built_bytes;
        building.max(plan.scene_bytes as f64 + scale * (built_bytes + finish_bytes))
    };
    Ok(Estimate {
        root_blocks,
        sampled_root_blocks: sampled,
        seconds: [0.6, 1.6].map(|spread| planning_seconds + spread * seconds),
        file_bytes: scales.map(|scale| (HEADER_BYTES as f64 + scale * merged_bytes) as u64),
        memory_bytes: scales.map(|scale| memory_bytes(scale) as u64),
    })
}
