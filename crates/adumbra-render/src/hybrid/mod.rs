//! Hybrid-resolution shadow maps: coarse where depth is smooth, fine where it breaks.
//!
//! Source: Li, Yang, Zhao, Chen, *Hybrid-resolution Shadow Mapping Design and Hard Shadows Anti-aliasing in Special Effects Movies*,
//! Chinese Optics 9 (1), 2016. Departures: a second, stricter test for merging ([`MergeTest::Plane`]) and texels of 32 bits beside the
//! paper's of 128 ([`HybridLayout`]); children lie in the order of their blocks, so the same depth gives the same map.
//!
//! [`HybridSettings`] → [`HybridMap`], a [`Technique`](crate::technique::Technique). A frame: a shadow map of the finest resolution is
//! drawn → [`build`] merges it level by level → the look-up, bind group 2. [`twin`] is all of it on the CPU, on the same depths.
//! [`upload`] gives the build a depth image from anywhere in place of a drawn one.

pub mod build;
mod map;
mod place;
mod settings;
mod stored;
pub mod twin;
pub mod upload;

pub use map::HybridMap;
pub use settings::{BuildKind, HybridLayout, HybridSettings, MergeTest, PlaneUnits};
