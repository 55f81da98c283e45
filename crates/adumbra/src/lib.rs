//! Bakes the sun's shadows of a static world into a small file that answers any point in space.
//!
//! Data flows one way: [`scene`] → [`light`] → [`bake`] → [`dag`] → [`mod@format`] → [`query`]; [`trace`] is the truth
//! that [`verify`] compares the answers with, and [`picture`] draws both. [`tree`] is the paper's form of the same answers,
//! and [`texture`] keeps its words in pictures. One polarity everywhere: *visibility*,
//! 1 = unoccluded.
//!
//! ```no_run
//! use std::path::Path;
//! use std::sync::atomic::AtomicBool;
//! use adumbra::format::{Layout, ShadowFile};
//! use adumbra::{bake, light::Sun, query::Query, scene};
//!
//! fn main() -> adumbra::Result<()> {
//!     let scene = scene::load(Path::new("city.glb"), &scene::LoadOptions::default())?;
//!     let options = bake::Options::new(Sun::from_direction([0.5, 0.8, 0.35])?, bake::Size::Resolution(8192));
//!     let baked = bake::bake(&scene, &options, &|_| {}, &AtomicBool::new(false))?;
//!     let file = ShadowFile::of_dag(baked.grid, baked.settings, baked.dag, Layout::Packed)?;
//!     file.write("city.adumbra")?;
//!     let query = Query::new(&file.grid, file.slabs(), file.settings.bias, 9)?;
//!     println!("{}", query.visibility([10.0, 1.8, 4.0], Some([0.0, 1.0, 0.0])));
//!     Ok(())
//! }
//! ```

pub mod bake;
pub mod camera;
pub mod dag;
pub mod error;
pub mod files;
pub mod format;
pub mod hierarchy;
pub mod light;
mod paged;
pub mod picture;
pub mod query;
pub mod scene;
pub mod settings;
#[cfg(test)]
#[path = "../tests/shared_folder/mod.rs"]
pub(crate) mod shared_folder;
pub mod texture;
pub mod trace;
pub mod tree;
pub mod verify;

pub use error::{Error, Result};

/// Compiles what the guide shows.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/guides/use-the-file-in-my-engine.md")]
struct Guide;
