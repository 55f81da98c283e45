//! One file per verb.

mod bake;
mod bake_tree;
mod bounds;
#[cfg(feature = "render")]
mod compare;
#[cfg(feature = "render")]
mod demo;
mod export;
mod export_web;
mod generate;
mod import;
mod info;
mod inspect;
#[cfg(all(test, feature = "view"))]
mod json_document;
mod lookup;
mod query;
#[cfg(feature = "render")]
mod render;
mod verify;
#[cfg(feature = "view")]
mod view;

use adumbra::layout::Composition;
use adumbra::{FormatError, ShadowFile};
use adumbra_program::exit::{Failure, Outcome};

use crate::args::Verb;

pub(crate) fn run(verb: Verb) -> Outcome {
    match verb {
        Verb::Generate(a) => generate::run(&a),
        Verb::Inspect(a) => inspect::run(&a),
        Verb::Bake(a) => bake::run(&a),
        Verb::Info(a) => info::run(&a),
        Verb::Verify(a) => verify::run(&a),
        Verb::Query(a) => query::run(&a),
        Verb::Export(a) => export::run(&a),
        Verb::Import(a) => import::run(&a),
        #[cfg(feature = "render")]
        Verb::Render(a) => Ok(render::run(&a)?),
        #[cfg(feature = "view")]
        Verb::View(a) => Ok(view::run(&a)?),
        #[cfg(feature = "render")]
        Verb::Compare(a) => Ok(compare::run(&a)?),
        #[cfg(feature = "render")]
        Verb::Demo(a) => demo::run(&a),
    }
}

/// Figures of a file that `bake` and `info` share.
struct GraphFigures {
    file_bytes: u64,
    bits_per_texel: f64,
    composition: Composition,
}

impl GraphFigures {
    /// Computes the figures. `file_bytes` is the length of the file as it was read or written.
    fn of(file: &ShadowFile, file_bytes: u64) -> Result<Self, Failure> {
        let texels = f64::from(file.grid.size[0]) * f64::from(file.grid.size[1]);
        let invalid = |e: FormatError| Failure::BadInput(e.to_string());
        Ok(Self {
            file_bytes,
            bits_per_texel: file_bytes as f64 * 8.0 / texels,
            composition: file.body.composition().map_err(invalid)?,
        })
    }
}
