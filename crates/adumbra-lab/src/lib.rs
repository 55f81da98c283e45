//! The laboratory: measures what `adumbra` bakes and draws, and repeats the measurements of the papers. What it compares
//! with the truth, it compares by [`adumbra_compare`].
//!
//! | module | contents |
//! |---|---|
//! | [`mod@bench`] | the benchmarks |
//! | [`mod@paper_report`] | the measurements of every paper, and the page that shows them |
//! | [`occlusion`], [`mod@tune_ao`] | ambient occlusion: errors, flicker, and the eight scenes it is measured on; the parameter search |
//! | [`peers`] | other engines' results |
//! | [`args`] | the command line |
//! | [`programs`] | the executables `adumbra-lab` and `adumbra` |

pub mod args;
pub mod bench;
pub mod occlusion;
pub mod paper_report;
pub mod peers;
pub mod programs;
mod results;
#[cfg(feature = "schema")]
pub mod schemas;
pub mod tune_ao;
