//! Bakes the sun's shadows of a static world into a small file that answers any point in space.
//!
//! Data flows one way: [`scene`] → [`light`] → [`bake`] → [`dag`] → [`format`] → [`query`]; [`trace`] is the truth
//! that [`verify`] compares the answers with. One polarity everywhere: *visibility*, 1 = unoccluded.

pub mod error;
pub mod format;
pub mod light;
pub mod dag;
pub mod scene;
pub mod settings;
pub mod trace;

pub use error::{Error, Result};
