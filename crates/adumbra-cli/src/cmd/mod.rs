//! One file per verb.

mod bake;
mod bake_path;
mod bake_regions;
mod bake_watch;
mod baking;
mod cache;
mod convert;
mod demo;
mod farm;
mod generate;
mod ground;
mod info;
mod inspect;
mod path;
mod query;
mod regions;
mod scale;
mod schema;
mod store;
mod sunlight;
mod verify;
#[cfg(feature = "view")]
mod view;

use adumbra::LightGrid;
#[cfg(feature = "render")]
use adumbra_compare::verbs::{Offer, compare, render};
use adumbra_program::exit::Outcome;

use crate::args::Verb;

pub(crate) fn run(verb: Verb) -> Outcome {
    match verb {
        Verb::Generate(a) => generate::run(&a),
        Verb::Inspect(a) => inspect::run(&a),
        Verb::Bake(a) => bake::run(&a),
        Verb::Info(a) => info::run(&a),
        Verb::Verify(a) => verify::run(&a),
        Verb::Query(a) => query::run(&a),
        Verb::Cache(a) => cache::run(&a),
        Verb::Plan(a) => farm::plan(&a),
        Verb::Tile(a) => farm::tile(&a),
        Verb::Link(a) => farm::link(&a),
        Verb::SunHours(a) => sunlight::hours(&a),
        Verb::Sky(a) => sunlight::sky(&a),
        Verb::Convert(a) => convert::run(&a),
        #[cfg(feature = "render")]
        Verb::Render(a) => Ok(render::run(&a, Offer::PRODUCT)?),
        #[cfg(feature = "view")]
        Verb::View(a) => Ok(view::run(&a)?),
        #[cfg(feature = "render")]
        Verb::Compare(a) => Ok(compare::run(&a, Offer::PRODUCT)?),
        Verb::Demo(a) => demo::run(&a),
        Verb::Schema(a) => schema::run(&a),
    }
}

/// Returns the bits of a file per texel of its finest grid.
fn bits_per_texel(grid: &LightGrid, file_bytes: u64) -> f64 {
    file_bytes as f64 * 8.0 / (f64::from(grid.size[0]) * f64::from(grid.size[1]))
}
