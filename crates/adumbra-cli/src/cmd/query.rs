//! `adumbra query`: points in, visibilities out.

use adumbra::ShadowFile;
use adumbra_program::exit::Outcome;
use adumbra_program::query::Query;

pub(crate) fn run(args: &Query) -> Outcome {
    args.check_outputs(None)?;
    let file = ShadowFile::read(&args.file)?;
    let points = args.read(file.encoded_len())?;
    args.answer(&points, &args.lookup.sampler(&file)?, None)
}
