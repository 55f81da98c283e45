//! The techniques of a comparison, and the truth that each is compared with.

use adumbra_program::exit::Failure;
use adumbra_render::{Renderer, TechniqueFiles, TechniqueSpec, Techniques, build};

use crate::Result;
use crate::args::ReferenceArg;
use crate::compare::{Contender, truth_for};
use crate::report::TruthKind;

/// Parses techniques of a list.
///
/// # Errors
///
/// Returns an error if a name is not a technique's or is given twice.
pub fn parse(techniques: Techniques, names: &[String]) -> Result<Vec<TechniqueSpec>> {
    let specs: Vec<TechniqueSpec> = names.iter().map(|s| techniques.parse(s)).collect::<Result<_, _>>()?;
    for (i, spec) in specs.iter().enumerate() {
        if specs[..i].contains(spec) {
            return Err(Failure::Usage(format!("--shadow {spec}: given twice")).into());
        }
    }
    Ok(specs)
}

/// Prepares each technique on the device.
///
/// # Errors
///
/// Returns an error if the device fails or a technique lacks the baked file that it needs.
pub fn contenders(
    renderer: &Renderer,
    specs: &[TechniqueSpec],
    baked: TechniqueFiles<'_>,
    reference: ReferenceArg,
) -> Result<Vec<Contender>> {
    let contender = |spec: &TechniqueSpec| {
        let prepared = if spec.is_traced() {
            None
        } else {
            Some(renderer.prepare(build(renderer.gpu(), spec, baked)?)?)
        };
        let truth = match reference {
            ReferenceArg::Technique => truth_for(spec),
            ReferenceArg::Hard => TruthKind::Hard,
            ReferenceArg::Disc => TruthKind::Disc,
        };
        Ok(Contender { spec: spec.clone(), prepared, truth })
    };
    specs.iter().map(contender).collect()
}
