//! What a bake will cost, from a few of its tiles.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::descent::{DescentBuffers, build_root};
use super::early::EarlySink;
use super::graph_sink::GraphSink;
use super::plain::{self, PlainBuffers};
use super::plan::Plan;
use super::{Builder, Options};
use crate::dag::store::NodeStore;
use crate::error::Result;
use crate::scene::Scene;

/// A forecast of [`super::bake`]; ranges are `[likely low, likely high]`.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Tiles in all.
    pub tiles: usize,
    /// Tiles that were drawn for the forecast.
    pub sampled_tiles: usize,
    /// Wall seconds on the current thread pool.
    pub seconds: [f64; 2],
    /// Bytes of the file.
    pub file_bytes: [u64; 2],
    /// Bytes that the bake would account for at its peak.
    pub memory_bytes: [u64; 2],
}

/// Tiles that a forecast draws.
const SAMPLES: usize = 48;

/// Draws a few tiles of the bake that `options` ask for, from the emptiest to the fullest, and extrapolates.
///
/// # Errors
/// As [`super::bake`], but the memory limit is reported in the forecast, not enforced on it.
pub fn estimate(scene: &Scene, options: &Options) -> Result<Estimate> {
    let plan = Plan::new(scene, &Options { max_memory_bytes: None, ..options.clone() })?;
    let tiles = plan.tiles();
    let sampled = tiles.min(SAMPLES);
    let (mut descent, mut plain) = (DescentBuffers::default(), PlainBuffers::default());
    let mut build = |tile: usize, store: &NodeStore| -> Result<()> {
        match options.builder {
            Builder::Fast => {
                let sink = EarlySink { early: plan.early(), sink: &GraphSink::new(store, plan.grid.size[2]) };
                build_root(&plan, tile, &sink, &mut descent, &AtomicBool::new(false))?;
            }
            Builder::Plain => {
                plain::build_root(&plan, tile, store, &mut plain);
            }
        }
        Ok(())
    };
    let merged = NodeStore::default();
    let mut separate_bytes = 0;
    let mut by_casters: Vec<usize> = (0..tiles).collect();
    by_casters.sort_by_key(|&tile| plan.casters.in_tile(tile).len());
    let start = Instant::now();
    for s in 0..sampled {
        // The middle one of each of as many equal runs.
        let tile = by_casters[(2 * s + 1) * tiles / (2 * sampled)];
        let alone = NodeStore::default();
        build(tile, &alone)?;
        separate_bytes += alone.graph_bytes();
        build(tile, &merged)?;
    }
    // Each was built twice.
    let seconds = start.elapsed().as_secs_f64() / 2.0 * tiles as f64 / (sampled * plan.workers) as f64;
    let scale = tiles as f64 / sampled as f64;
    // All tiles alike in bytes is the most; the sharing seen among the few goes on among the many is the least.
    let most = merged.graph_bytes() as f64 * scale;
    let sharing = merged.graph_bytes() as f64 / (separate_bytes as f64).max(1.0);
    let least = most * sharing.powf(scale.log2().max(0.0)).max(0.25);
    let top_bytes = tiles as f64 * f64::from(plan.top_dims[2]) * 4.0;
    let file_bytes = [least, most].map(|b| (b + top_bytes) as u64);
    let fixed = plan.scene_bytes + plan.workers as u64 * plan.worker_bytes;
    Ok(Estimate {
        tiles,
        sampled_tiles: sampled,
        seconds: [seconds * 0.6, seconds * 1.6],
        file_bytes,
        // The store's tables and spare room, and its renumbered copy.
        memory_bytes: file_bytes.map(|b| fixed + 4 * b),
    })
}
