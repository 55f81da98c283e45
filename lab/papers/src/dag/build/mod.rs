//! Bakes the graph of a scene, from the columns that `adumbra_bake` finds, and converts graphs.
//!
//! | module | contents |
//! |---|---|
//! | `sink` | columns become runs of nodes along the light |
//! | [`store`] | equal nodes are stored once, and numbered in the order of first visit |
//! | `pack` | the plain graph becomes the packed one |
//! | [`convert`] | between the layouts of a graph, and between graphs and quadtrees |
//!
//! - *A node without leaf masks below it* may be shared by several levels. In the packed layout each level
//!   has its own.
//! - *The packed layout* cannot hold a graph whose columns are not monotone along the light, and packing one
//!   is an error. No bake makes one.
//! - Everything is in memory.

pub mod convert;
mod pack;
mod sink;
pub mod store;

use adumbra_bake::structure::{BuiltStructure, build};
use adumbra_bake::{BakeOptions, Report, Watch};
use adumbra_scene::Scene;

pub use pack::pack;
pub use sink::GraphSink;

use crate::dag::{DagFile, DagLayout, Result};

/// The options of a bake.
#[derive(Clone, Debug)]
pub struct DagOptions {
    /// The options that determine the columns.
    pub bake: BakeOptions,
    /// The layout of the graph.
    pub layout: DagLayout,
}

/// A finished bake.
#[derive(Debug)]
pub struct BakedDag {
    /// The graph file.
    pub file: DagFile,
    /// Statistics of the bake. They do not include packing.
    pub report: Report,
}

/// Bakes the graph of `scene`.
///
/// # Errors
/// Returns the errors of [`adumbra_bake::Bake`], and [`Error::Pack`](crate::dag::Error::Pack) if the graph
/// has no packed form. A graph never goes to disk: exceeding the memory limit is an error.
pub fn bake(scene: &Scene, options: &DagOptions, watch: Watch<'_>) -> Result<BakedDag> {
    let BuiltStructure { grid, settings, made, report } = build(scene, &options.bake, watch, GraphSink::new)?;
    let body = convert::body_in(options.layout, made)?;
    Ok(BakedDag { file: DagFile { grid, settings, body }, report })
}
