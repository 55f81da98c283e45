//! Hybrid-resolution shadow maps: coarse where depth is smooth, fine at its discontinuities.
//!
//! Source: Li, Yang, Zhao, Chen, *Hybrid-resolution Shadow Mapping Design and Hard Shadows Anti-aliasing in
//! Special Effects Movies*, Chinese Optics 9 (1), 2016.
//!
//! [`HybridSettings`] → [`HybridMap`], a [`Technique`](crate::technique::Technique). [`twin`] implements all
//! of it on the CPU: tests compare the map word for word and the look-up pixel by pixel. [`upload`] supplies
//! the build with an arbitrary depth image instead of a rendered one. The stages of a frame:
//!
//! | stage | pass | output |
//! |---|---|---|
//! | depth | `map_depth`, `map_normals` | a shadow map at the finest resolution, plus normals for [`HybridLayout::Paper`] |
//! | [`build`], for each level | `hybrid_sweep` or `hybrid_blocks` ([`BuildKind`]) | one word per block of four texels: a merged texel, or a mark that the block splits; counts of the blocks that split |
//! | | `hybrid_scan` | the offset at which the children of each section begin |
//! | | `hybrid_place`, `hybrid_place_paper` | the children, appended to the map; for the last level, the coarsest texels |
//! | look-up, bind group 2 | `hybrid_nearest`, `hybrid_pcf` | visibility, descending from the coarsest texel until a depth is reached |
//!
//! Two layouts ([`HybridLayout`]) hold the same texels in the same order and give bit-identical answers:
//! 32-bit words (access/hybrid_compact.wgsl), and the paper's 128-bit texels with lists of links
//! (access/hybrid_paper.wgsl).
//!
//! The offset of a block's children follows from the block's rank, not from the order in which threads
//! arrive. So the same depth gives the same words with either build pass. No pass waits for the CPU: buffers
//! are sized for the largest possible map until `static=cached` copies the part in use and frees the rest. If
//! one binding cannot hold the largest map, the buffer is as large as a binding may be, and the frame fails
//! if the map needs more.
//!
//! Departures from the paper:
//!
//! - A merged texel may be a plane ([`MergeTest::Plane`], the default). No finest texel is behind it, and
//!   none is further in front of it than the tolerance. So slopes merge, and no surface shadows itself.
//! - The paper's equation 1 ([`MergeTest::Paper`]) divides by a texel's distance from the light, which is
//!   undefined for a sun. Here it divides by the depth within the layer's range, whose near plane is slightly
//!   in front of the nearest caster. So the depth difference that may merge grows with the distance from that
//!   plane.
//! - Comparisons are those of a shadow map at the centres of the finest texels. Where nothing merged, the
//!   answers equal the shadow map's.
//! - A filter no wider than a coarsest texel compares against the coarsest texels first, each as a whole
//!   plane. It reads finest texels only where those texels split or disagree. A wider filter reads the blocks
//!   directly.
//! - Links are indices, not pointers. Children are ordered by block, not by the order in which they were
//!   found. The paper specifies the bits of channel A only; those of R, G and B are our own.
//! - A merged texel of the paper's layout holds the mean normal of its children. No look-up reads it.
//! - 16-bit depths are rounded to their quantization steps before they merge, because devices convert them to
//!   floats in different ways.

pub mod build;
mod map;
mod place;
mod settings;
mod stored;
pub mod twin;
pub mod upload;

pub use map::HybridMap;
pub use settings::{BuildKind, HybridLayout, HybridSettings, MergeTest, PlaneUnits};
pub use stored::BuiltCounts;
