//! Which parts of the sky points see.

mod patches;
mod views;

pub use patches::Patches;
pub use views::{SkyView, sky_views};
