//! Shadow maps: one depth texture of 1 to 8 layers, a fit and a filter.
//!
//! [`MapSettings`] → [`ShadowMap`], a [`Technique`](crate::technique::Technique). A frame: [`cascades`] says where the layers lie →
//! `depth_pass` draws casters into each → `moments_pass`, for filters that blur statistics → the look-up, bind group 2. [`twin`] is
//! the look-up on the CPU.

pub mod cascades;
pub(crate) mod depth_pass;
pub(crate) mod layers;
mod moments_pass;
mod params;
mod shadow_map;
mod spec;
pub(crate) mod textures;
pub(crate) mod told;
pub mod twin;

pub use moments_pass::gaussian;
pub use params::{
    CascadeSettings, DepthPrecision, MapBias, MapCasters, MapFilter, MapFit, MapSettings, MomentKind,
    MomentSettings, Split,
};
pub use shadow_map::ShadowMap;
pub(crate) use shadow_map::scene_fit;
pub(crate) use spec::cache_static;
