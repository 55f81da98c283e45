//! `adumbra query`: points in, visibilities out.

use adumbra::ShadowFile;
use adumbra_program::exit::Outcome;

use crate::args::QueryFile;

pub(crate) fn run(QueryFile { query: args, level }: &QueryFile) -> Outcome {
    args.check_outputs(None)?;
    let file = level.of(&ShadowFile::read(&args.file)?, &args.file)?;
    let points = args.read(file.encoded_len())?;
    args.answer(&points, &args.lookup.sampler(&file)?, None)
}
