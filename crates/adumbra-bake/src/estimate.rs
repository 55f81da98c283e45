//! Forecasts the cost of a bake from a few of its tiles.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use crate::choose;
use crate::error::Result;
use crate::fast::descent::{DescentBuffers, build_root};
use crate::options::{BakeOptions, Builder};
use crate::plain::build as plain;
use crate::plain::build::PlainBuffers;
use crate::sink::limit::LimitSink;
use crate::sink::runs::GraphSink;
use crate::store::NodeStore;
use adumbra_scene::Scene;

/// A forecast of [`crate::bake`]. Ranges are `[likely low, likely high]`.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    /// Total number of tiles.
    pub tiles: usize,
    /// Number of tiles that were drawn for the forecast.
    pub sampled_tiles: usize,
    /// Wall-clock seconds on the current thread pool.
    pub seconds: [f64; 2],
    /// Size of the file in bytes.
    pub file_bytes: [u64; 2],
    /// Peak of the bytes that the bake would account for.
    pub memory_bytes: [u64; 2],
}

/// Number of tiles drawn for a forecast.
const SAMPLES: usize = 48;

/// Draws a few tiles of the bake for `options`, from the emptiest to the fullest, and extrapolates.
///
/// # Errors
/// Returns the errors of [`crate::bake`]. The memory limit holds for the forecast, not for the bake that it is about.
pub fn estimate(scene: &Scene, options: &BakeOptions) -> Result<Estimate> {
    options.check_layout()?;
    let plan = choose::plan(scene, options)?;
    let tiles = plan.tiles.count();
    let sampled = tiles.min(SAMPLES);
    let (mut descent, mut plain) = (DescentBuffers::default(), PlainBuffers::default());
    let mut build = |tile: usize, store: &NodeStore| -> Result<()> {
        match options.builder {
            Builder::Fast => {
                let sink = LimitSink {
                    limit: plan.switch_limit(),
                    sink: &GraphSink::new(store, plan.tiles.grid.size[2]),
                };
                build_root(&plan.tiles, tile, &sink, &mut descent, &AtomicBool::new(false))?;
            }
            Builder::Plain => {
                plain::build_root(&plan.tiles, plan.switch_limit(), tile, store, &mut plain);
            }
        }
        Ok(())
    };
    let merged = NodeStore::default();
    let mut separate_bytes = 0;
    let start = Instant::now();
    let fullness = |tile| plan.tiles.casters.in_tile(tile).len() as u64;
    for tile in plan.tiles.sampled(sampled, fullness) {
        let alone = NodeStore::default();
        build(tile, &alone)?;
        separate_bytes += alone.graph_bytes();
        build(tile, &merged)?;
        let held_bytes = plan.scene_bytes + plan.worker_bytes + merged.memory_bytes() + alone.memory_bytes();
        plan.check_memory("the forecast", held_bytes)?;
    }
    // Each tile was built twice.
    let seconds = start.elapsed().as_secs_f64() / 2.0 * tiles as f64 / (sampled * plan.workers) as f64;
    let scale = tiles as f64 / sampled as f64;
    // Upper bound: every tile adds as many bytes as the sampled ones. Lower bound: the sharing seen among the samples
    // continues over all tiles.
    let most = merged.graph_bytes() as f64 * scale;
    let sharing = merged.graph_bytes() as f64 / (separate_bytes as f64).max(1.0);
    let least = most * sharing.powf(scale.log2().max(0.0)).max(0.25);
    let top_bytes = tiles as f64 * f64::from(plan.tiles.top_dims[2]) * 4.0;
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
