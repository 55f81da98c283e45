//! The laboratory of the papers: data structures and techniques that the product has left behind, kept
//! working so that they can be compared with it.
//!
//! | module | paper |
//! |---|---|
//! | [`dag`] | the graphs of *Compact Precomputed Voxelized Shadows* (2014) |
//! | [`tree`] | the world-aligned tree of *The Optimization and realization of Compact Precomputed Voxelized Shadows Algorithm* (2021) |
//! | `techniques` (feature `gpu`) | look-ups in them on the GPU, as techniques of `adumbra_render` |
//!
//! Nothing that is published depends on this crate.

pub mod dag;
mod kinds;
mod sections;
#[cfg(feature = "gpu")]
pub mod techniques;
pub mod tree;

pub use sections::SectionFault;
