//! The laboratory: measures what `adumbra` bakes and draws, and repeats the measurements of the papers.
//! Comparisons with the truth use [`adumbra_compare`].
//!
//! | module | contents |
//! |---|---|
//! | [`mod@bench`] | the benchmarks |
//! | [`mod@paper_report`] | the measurements of every paper, and the page that shows them |
//! | [`occlusion`], [`mod@tune_ao`] | ambient occlusion: errors, flicker, and the eight scenes it is measured on; the parameter search |
//! | [`peers`] | other engines' results |
//! | [`mod@dag`], [`mod@tree`] | the verbs `dag` and `tree`: files of the papers of 2014 and 2021 |
//! | [`mod@schemas`] | the verb `schema` |
//! | [`args`] | the command line |
//! | [`programs`] | the executables `adumbra-lab` and `adumbra` |

pub mod args;
pub mod bench;
pub mod dag;
mod light_file;
mod mirrors;
pub mod occlusion;
pub mod paper_report;
pub mod peers;
pub mod programs;
mod results;
pub mod schemas;
pub mod tree;
pub mod tune_ao;

use adumbra_render::Techniques;

/// The product's techniques and the papers'.
pub const TECHNIQUES: Techniques = Techniques::product().with(adumbra_papers::techniques::TECHNIQUES);
