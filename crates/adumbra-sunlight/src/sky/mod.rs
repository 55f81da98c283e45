//! The parts of the sky that points see.

mod patches;
mod views;

pub use patches::Patches;
pub use views::{SkyView, sky_views};
