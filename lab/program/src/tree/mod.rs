//! `adumbra-lab tree`: bakes, describes, looks up and exports trees of the 2021 paper.

pub(crate) mod bake;
pub(crate) mod export;
pub(crate) mod import;
pub(crate) mod info;
mod lookup;

use adumbra_program::exit::Outcome;

use crate::args::TreeVerb;

/// Runs the verb.
///
/// # Errors
///
/// Returns an error for wrong arguments, and for inputs and outputs that cannot be read or written.
pub fn run(verb: &TreeVerb) -> Outcome {
    match verb {
        TreeVerb::Bake(args) => bake::run(args),
        TreeVerb::Info(args) => info::run(args),
        TreeVerb::Verify(args) => lookup::verify(args),
        TreeVerb::Query(args) => lookup::query(args),
        TreeVerb::Export(args) => export::run(args),
        TreeVerb::Import(args) => import::run(args),
    }
}
