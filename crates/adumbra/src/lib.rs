//! Bakes the sun's shadows of a static world into a small file that answers any point in space.
//!
//! Data flows one way: [`scene`] → [`light`] → [`bake`] → [`dag`] → [`format`] → [`query`]; [`trace`] is the truth
//! that [`verify`] compares the answers with, and [`picture`] draws both. One polarity everywhere: *visibility*,
//! 1 = unoccluded.

pub mod bake;
pub mod dag;
pub mod error;
pub mod format;
pub mod light;
pub mod picture;
pub mod query;
pub mod scene;
pub mod settings;
pub mod trace;
pub mod verify;

pub use error::{Error, Result};
