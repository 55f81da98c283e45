//! Shadow maps: one depth texture of 1 to 8 layers, a fit and a filter.
//!
//! [`MapSettings`] → [`ShadowMap`], a [`Technique`](crate::technique::Technique). Stages of a frame:
//! [`cascades`] computes the placement of the layers → `depth_pass` draws casters into each → `moments_pass`
//! fills moments, for filters that blur statistics → the look-up, bind group 2. [`twin`] is the look-up on
//! the CPU.

pub mod cascades;
pub(crate) mod depth_pass;
pub(crate) mod help;
pub(crate) mod layers;
mod moments_pass;
mod params;
mod shadow_map;
mod spec;
pub(crate) mod textures;
pub mod twin;

pub use moments_pass::gaussian;
pub use params::{
    CascadeSettings, DepthPrecision, MapBias, MapCasters, MapFilter, MapFit, MapSettings, MomentKind,
    MomentSettings, Split,
};
pub use shadow_map::ShadowMap;
pub(crate) use shadow_map::scene_fit;
pub(crate) use spec::{MapKind, cache_static};
