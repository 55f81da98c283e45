//! Compares shadows and ambient occlusion with ray-traced truth, and measures what `adumbra` bakes and draws.
//!
//! The comparison is a library, which `adumbra compare` and the viewer use too. The program `adumbra-lab` runs the
//! benchmarks and the report.
//!
//! | module | contents |
//! |---|---|
//! | [`truth`] | ray-traced surfaces, sun and ambient visibility, cached; shadow edges; street-level cameras |
//! | [`metrics`] | RMSE and shares of wrong pixels for shadow factors, by distance; SSIM and FLIP for pictures |
//! | [`mod@compare`] | techniques drawn at one camera or along a path, and compared with the truth |
//! | [`camera_file`] | cameras as JSON |
//! | [`paths`], [`shimmer`] | camera paths; how shadow factors at fixed points change along them |
//! | [`occlusion`] | ambient occlusion: errors, flicker, and the eight scenes it is measured on |
//! | [`page`] | self-contained HTML pages |
//! | [`report`], [`pictures`], [`peers`] | tables and JSON; difference pictures and sheets; other engines' results |
//! | [`contenders`], [`baked`] | the techniques of a comparison, and the baked files that they need |
//! | [`layers`], [`plot`] | layers of a frame as PNG and EXR; plots as SVG |
//! | [`args`] | command-line options that need the renderer |
//! | [`mod@bench`], [`mod@tune_ao`] | the benchmarks; the parameter search for ambient occlusion |
//! | [`mod@paper_report`] | the measurements of every paper, and the page that shows them |
//! | [`programs`] | the executables `adumbra-lab` and `adumbra` |

pub mod args;
pub mod baked;
pub mod bench;
pub mod camera_file;
pub mod compare;
pub mod contenders;
pub mod error;
pub mod layers;
pub mod metrics;
pub mod occlusion;
pub mod page;
pub mod paper_report;
pub mod paths;
pub mod peers;
pub mod pictures;
pub mod plot;
pub mod programs;
pub mod report;
mod results;
#[cfg(feature = "schema")]
pub mod schemas;
pub mod shimmer;
pub mod truth;
pub mod tune_ao;
mod vector;

pub use error::{Error, Result};
