//! The bake, for every layout.

pub(crate) mod depths;
pub(crate) mod graph;
#[cfg(test)]
mod memory_tests;
mod run;

use std::time::Instant;

use adumbra::{LightBody, ShadowFile};
use adumbra_scene::Scene;

use crate::choose;
use crate::error::PackError;
use crate::error::{Error, Result};
use crate::options::{BakeOptions, LayoutChoice};
use crate::pack::pack;
use crate::progress::{Report, Watch};
use crate::tally::Tally;

/// A finished bake.
#[derive(Debug)]
pub struct Bake {
    /// The file that an engine loads.
    pub file: ShadowFile,
    /// Bytes per layout, if [`LayoutChoice::Auto`] asked for the smaller file.
    pub candidates: Option<CandidateBytes>,
    /// Statistics of the bake.
    pub report: Report,
}

/// Bytes that the file would have in each layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CandidateBytes {
    /// In the packed layout; `None` if it cannot hold the voxels.
    pub packed: Option<u64>,
    /// In the layout of depths.
    pub depths: u64,
}

/// Bakes `scene`.
///
/// Progress is reported from worker threads after each root block, and the cancel flag is read before each. Runs on the
/// current rayon pool. Cost of [`Builder::Fast`](crate::Builder::Fast): time and memory grow with the scene and with
/// the length of the silhouettes in texels. Cost of [`Builder::Plain`](crate::Builder::Plain): time grows with texels
/// times layers.
///
/// # Errors
/// Returns an error if an option is out of range, or if a scene, tables or a result do not fit `max_memory_bytes`.
/// Returns [`Error::Pack`] if the graph has no packed form, [`Error::Spill`] if data that does not fit into memory
/// cannot be written to disk, and [`Error::Interrupted`] if the caller cancels.
pub fn bake(scene: &Scene, options: &BakeOptions, watch: Watch<'_>) -> Result<Bake> {
    let start = Instant::now();
    options.check_layout()?;
    let plan = choose::plan(scene, options)?;
    let tally = Tally::new(&plan, start, watch.progress);
    let cancel = watch.cancel;
    let (body, candidates) = match options.layout {
        LayoutChoice::Plain => {
            (LightBody::Plain(graph::plain(&plan, &tally, options.builder, cancel)?), None)
        }
        LayoutChoice::Packed => {
            (LightBody::Packed(graph::packed(&plan, &tally, options.builder, cancel)?), None)
        }
        LayoutChoice::Depths => (LightBody::Depths(depths::depths(&plan, &tally, true, cancel)?), None),
        LayoutChoice::Auto => {
            let (dag, depths) = graph::both(&plan, &tally, cancel)?;
            let len = |body: &LightBody| body.encoded_len();
            let depths = LightBody::Depths(depths);
            // If the graph has no packed form, the depths remain.
            let packed = match pack(&dag) {
                Ok(packed) => Some(LightBody::Packed(packed)),
                Err(PackError::TooLarge { .. } | PackError::NotMonotone { .. }) => None,
                Err(fault) => return Err(Error::from(fault)),
            };
            let candidates = CandidateBytes { packed: packed.as_ref().map(len), depths: len(&depths) };
            let smaller = packed.filter(|packed| len(packed) < len(&depths));
            (smaller.unwrap_or(depths), Some(candidates))
        }
    };
    let file = ShadowFile { grid: plan.tiles.grid, settings: plan.settings, body };
    Ok(Bake { file, candidates, report: tally.report() })
}
