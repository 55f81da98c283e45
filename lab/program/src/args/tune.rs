//! Options of `tune-ao`.

use std::path::PathBuf;

use adumbra_render::SpecText;
use adumbra_render::occlusion::Estimator;

use adumbra_compare::args::DeviceArgs;

/// Options of `tune-ao`.
#[derive(clap::Args)]
pub struct TuneAo {
    /// Folder of the eight scenes
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: PathBuf,
    /// Settings tried per estimator and half of the scenes
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) budget: u32,
    /// Tune only these estimators; the others keep their entries if those are for the same scenes and options
    #[arg(long, value_name = "NAME", value_delimiter = ',', value_parser = estimator)]
    pub(crate) only: Vec<Estimator>,
    /// Tune an estimator with fixed values for parameters that take names or are not searched; may be
    /// repeated; prints the results and records nothing
    #[arg(long, value_name = "NAME:KEY=VALUE...", conflicts_with = "only", value_parser = variant)]
    pub(crate) variant: Vec<SpecText>,
    /// Record to update; the program is built with it
    #[arg(long, value_name = "FILE", default_value = "lab/program/data/ao_tuning.json")]
    pub(crate) record: PathBuf,
    /// Table to write
    #[arg(long, value_name = "FILE", default_value = "docs/bench/ao-tuning.md")]
    pub(crate) table: PathBuf,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

fn estimator(text: &str) -> Result<Estimator, String> {
    let found = Estimator::ALL.into_iter().find(|e| e.name() == text);
    found.ok_or_else(|| format!("give one of {}", Estimator::ALL.map(|e| e.name()).join(", ")))
}

fn variant(text: &str) -> Result<SpecText, String> {
    text.parse().map_err(|e: adumbra_render::RenderError| e.to_string())
}
