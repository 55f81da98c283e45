//! The reference for baked shadows: rays traced through the scene.
//!
//! [`trace`] finds hits and visibility. [`verify`] compares a file's answers with rays at random points.
//! [`picture`] draws both on the CPU. [`glance`] says what a person would see of a scene. [`movers`] finds
//! paths for a ball that moves from sunlight into shadow. One convention everywhere: *visibility*, 1 =
//! unoccluded.

pub mod glance;
pub mod movers;
pub mod picture;
pub mod trace;
pub mod verify;
