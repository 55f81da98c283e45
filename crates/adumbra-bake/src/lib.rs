//! Bakes the sun's shadows of a scene: scene and sun in, shadow file out. The bake works in columns along the
//! light, one root block at a time per core. The depth image is never whole in memory, and
//! most of it is never drawn.
//!
//! Sources: Sintorn, Kämpe, Olsson, Assarsson, *Compact Precomputed Voxelized Shadows*, 2014, for columns
//! along the light that are free where nothing looks; Scandolo, Bauszat, Eisemann, *Merged Multiresolution
//! Hierarchies for Shadow Map Compression*, 2016, for the quadtree; §3 of the specification for what a column
//! allows. The result does not depend on the number of threads, the order of blocks or of triangles, or the
//! memory limit.
//!
//! ```no_run
//! use adumbra_bake::Bake;
//!
//! let scene = adumbra_scene::load("city.glb".as_ref(), &Default::default())?;
//! let sun = adumbra::Sun::from_direction([0.5, 0.8, 0.35])?;
//! Bake::new(&scene, sun).resolution(8192).save("city.adumbra")?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A bake
//!
//! 1. `triangles/`: triangles are grouped into clusters of nearby ones, and clusters are binned by root block
//!    of the light's plane. Instances stay instances. A triangle is projected with integer edge functions on
//!    coordinates snapped to 1/256 texel; its depth comes from the unsnapped plane.
//! 2. `columns/`: the column rules. A column's first surface, the end of its solid and the next receiver give
//!    `e` and `x`: lit before `e`, shadowed from `x` on, free in between.
//! 3. `root_blocks`, `plan`: workers take root blocks one after another. No result depends on which worker
//!    built what, or when.
//! 4. `fast/`: the surfaces of a root block are gathered into connected components that face one way, and
//!    edges that are a *contour* under this sun are marked. A component without a contour in a block covers
//!    either all of its texels or none, and one sample decides which. This bounds the block's largest `e` and
//!    smallest `x`; if `x >= e`, the block is *resolved*. A quadtree descent stops at resolved blocks. Blocks
//!    of 8 × 8 texels that are still not resolved are drawn, front to back, in bit masks. The switch limit
//!    then cuts the columns' freedom, for filters beside a wall's foot.
//! 5. `sink/`: the interface between the descent and what it fills. A sink takes resolved blocks and leaves,
//!    and joins four into one. The quadtree's sink intersects intervals on the way up, and chooses depths
//!    from each root down.
//! 6. `pack/`: leaves are encoded as few depths or planes, whichever suffice.
//! 7. `pages/`: a finished root becomes a page at once, in which equal shapes are stored once. With a memory
//!    limit, pages go to an unnamed temporary file. At the end they are linked: shapes are hashed to 128
//!    bits, those of three or more pages become the common section, and every page is written again with
//!    pointers into it, on all threads. The file is streamed out bundle by bundle.
//!
//! `plain/` is a second builder, for tests: it draws every texel, in two passes, surfaces and crossings of
//! solids at texel centres first, then the nearest receiver behind each column's caster. The tests compare
//! the fast builder with it (`plain/agreement.rs`), it with every triangle at every column
//! (`plain/reference.rs`), and files of random scenes with columns and rays (`fuzz/`).
//!
//! `cache/` keeps what was made of each part of a grid under a key of all that it was made from (`inputs`),
//! so that the next bake need not make it again. `farm/` plans a bake whose parts other machines bake, and
//! links them. [`Baker`] holds a scene and its parts while it is edited.
//!
//! `ground` says whether a scene has a ground of its own. `choose` plans a bake in the frame that was asked
//! for, or in the one that a few blocks forecast to be better. `regions` cuts a world that is too wide for
//! one file into regions with a file each; `region_grids` places their grids.
//!
//! Dependencies go one way: triangles → columns → root_blocks → pack → pages → cache → sink → fast and plain
//! → plan → region_grids → ground → choose → regions → inputs → bake → farm → baker. `layers` provides
//! first surfaces and crossings of solids to structures that voxelize depth themselves.
//!
//! # Design decisions, and departures from the specification
//!
//! - *Shadow first.* A cube that may be either lit or shadowed is shadowed, so the switch stays at the first
//!   surface wherever that costs nothing, and an object's foot has no gap.
//! - *A receiver behind* a column's first surface is evaluated where look-ups sample it: on its own plane at
//!   the texel's centre, lifted by its own bias. The column is shadowed there if that point is behind the
//!   first surface. This replaced two rules, half the gap to the receiver and the bias at the first surface's
//!   slope, which lost the shadows of layers nearer than twice the bias.
//! - *Seams.* Corners are snapped to 1/256 texel, so a corner on a neighbour's edge may leave that edge. Open
//!   surfaces are grown by one such step, and so are solids where two of them meet.
//! - *Inside solids* the file may say either lit or shadowed, since no camera sees it; `verify` does not
//!   compare such points.
//! - Root blocks are 2^5 to 2^13 texels a side, about 32 across the longer side of the light's plane. Those
//!   smaller than a page of 2^9 wait for their neighbours.
//! - A file has coarser levels, each a bake of its own with voxels four times as large, on a lattice with the
//!   same origin.
//! - The grid has a margin of one voxel before the first surface and behind the last.
//! - Static receivers are answered for filters up to 9 texels wide, with normals.

#![forbid(unsafe_code)]

mod bake;
mod baker;
mod cache;
mod choose;
mod columns;
mod error;
mod farm;
mod fast;
#[cfg(test)]
mod fuzz;
mod ground;
mod inputs;
mod layers;
mod options;
mod pack;
mod pages;
mod plain;
mod plan;
mod progress;
mod region_grids;
mod regions;
mod root_blocks;
mod sink;
mod tally;
#[cfg(test)]
mod test_bakes;
mod texel_mask;
mod triangles;
mod yaw;

pub use bake::{Bake, BakeSummary, Estimate};
pub use baker::Baker;
#[doc(hidden)]
pub use cache::ENTRY_MAGIC;
pub use cache::{BakeCache, BestEffortCache, CacheKey, CacheReport, DiskCache, Fetched, MemoryCache};
pub use error::{BakeField, Error};
pub use farm::{BakePlan, BakedParts, PartBaker, PlannedPart};
#[doc(hidden)]
pub use ground::Ground;
#[doc(hidden)]
pub use options::ColumnBuilder;
pub use options::{AssumeGround, BakeOptions, FrameChoice, Size};
pub use progress::{Progress, Report, Watch};
pub use regions::RegionPlan;

/// What is needed to build another structure than the quadtree from the same columns.
#[doc(hidden)]
pub mod structure {
    pub use crate::bake::structure::{BuiltStructure, build};
    pub use crate::columns::BlockColumns;
    pub use crate::columns::rules::{BESIDE_GRID, FREE_TO_END};
    pub use crate::options::check_bounds;
    pub use crate::pages::Pages;
    pub use crate::sink::depths::{DepthsBlock, DepthsSink};
    pub use crate::sink::{BlockSink, Structure};

    /// First surfaces, and the crossings of solids, tile by tile.
    pub mod layers {
        pub use crate::columns::capture::{CaptureBuffers, working_bytes};
        pub use crate::columns::crossings::crossing;
        pub use crate::layers::{LayerCapture, LayerOptions, sorting_bytes};
        pub use crate::triangles::depth::FixedDepth;
    }
}
