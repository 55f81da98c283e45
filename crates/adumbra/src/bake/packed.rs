//! The bake into the packed layout: with a limit, the plain graph is never whole in memory.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use super::plan::Plan;
use super::tally::Tally;
use super::{Options, Progress, Report, build_graph, number_graph};
use crate::dag::packed::PackedDag;
use crate::error::Result;
use crate::light::LightGrid;
use crate::scene::Scene;
use crate::settings::Settings;

/// A finished bake.
#[derive(Debug)]
pub struct BakedPacked {
    /// Where the grid lies.
    pub grid: LightGrid,
    /// What was asked for.
    pub settings: Settings,
    /// The answers.
    pub packed: PackedDag,
    /// How it went.
    pub report: Report,
}

/// Bakes `scene` as [`super::bake`] does, and packs the graph.
///
/// # Errors
/// As [`super::bake`]; [`Error::Pack`](crate::Error::Pack) where the graph is too large for the layout.
pub fn bake_packed(
    scene: &Scene,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
    cancel: &AtomicBool,
) -> Result<BakedPacked> {
    let start = Instant::now();
    let plan = Plan::new(scene, options)?;
    let tally = Tally::new(&plan, start, progress);
    let (store, columns) = build_graph(&plan, &tally, options.builder, cancel)?;
    let (numbered, mut held_bytes) = number_graph(store, &plan, &tally, &columns, 0)?;
    if plan.spill.is_none() {
        held_bytes += numbered.graph_bytes();
    }
    let make_room = |bytes| tally.check_end("packing the graph", held_bytes + bytes);
    let packed = PackedDag::of_paged(numbered, make_room)?;
    plan.paged_bytes()?;
    Ok(BakedPacked { grid: plan.grid, settings: plan.settings, packed, report: tally.report() })
}
