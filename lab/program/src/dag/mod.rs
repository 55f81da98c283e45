//! `adumbra-lab dag`: bakes, describes and looks up graphs of the 2014 paper.

pub(crate) mod bake;
pub(crate) mod info;

use adumbra::Filter;
use adumbra_papers::dag::{DagFile, DagQuery};
use adumbra_program::exit::{Failure, Outcome};
use adumbra_program::lookup::LookupArgs;
use adumbra_program::query::Query;
use adumbra_program::verify::{Verified, Verify};
use adumbra_scene::{Casters, LoadedAs};
use adumbra_truth::verify::{LightAnswers, VolumeSampler};

use crate::args::DagVerb;

/// Runs the verb.
///
/// # Errors
///
/// Returns an error for wrong arguments, and for inputs and outputs that cannot be read or written.
pub fn run(verb: &DagVerb) -> Outcome {
    match verb {
        DagVerb::Bake(args) => bake::run(args),
        DagVerb::Info(args) => info::run(args),
        DagVerb::Verify(args) => verify(args),
        DagVerb::Query(args) => query(args),
    }
}

fn look_up<'f>(args: &LookupArgs, file: &'f DagFile) -> Result<DagQuery<'f>, Failure> {
    let bias = args.bias.over(file.settings.bias)?;
    Ok(DagQuery::new(&file.grid, file.body.leaf_masks(), bias, Filter::try_from(args.filter)?))
}

fn query(args: &Query) -> Outcome {
    args.check_outputs(None)?;
    args.run.memory_limit().check_plain_file(&args.file)?;
    let file = DagFile::read(&args.file)?;
    let points = args.read()?;
    args.answer(&points, &look_up(&args.lookup, &file)?, None)
}

fn verify(args: &Verify) -> Outcome {
    args.run.memory_limit().check_plain_file(&args.file)?;
    let file = DagFile::read(&args.file)?;
    if args.volume && file.settings.assume_ground {
        return Err(Failure::Usage(format!(
            "{} was baked with ground assumed, so it promises nothing about points in free space; bake with --no-assume-ground",
            args.file.display()
        )));
    }
    let verified = Verified {
        sun: file.grid.sun,
        voxel_size: file.grid.voxel_size,
        is_finest: true,
        scene: LoadedAs::from(&file.settings),
        assumes_ground: file.settings.assume_ground,
        casters: Some(Casters { triangles: file.settings.triangles, instances: file.settings.instances }),
        volume: VolumeSampler::new(&file.grid),
    };
    let query = look_up(&args.lookup, &file)?;
    args.compare(
        verified,
        &LightAnswers::new(file.grid, file.settings, query, (query.filter(), query.bias())),
    )
}
