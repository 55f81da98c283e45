//! `adumbra query`: points in, visibilities out.

use adumbra_program::exit::{Failure, Outcome};
use adumbra_program::moment;

use super::{path, regions};
use crate::args::QueryFile;

pub(crate) fn run(QueryFile { query: args, level, time }: &QueryFile) -> Outcome {
    args.check_outputs(None)?;
    if let Some(sun_path) = moment::sun_path(&args.file)? {
        return path::query(args, &sun_path, *time, level.level);
    }
    if time.is_some() {
        let file = args.file.display();
        return Err(Failure::Usage(format!("--time: {file} is the file of one sun; give a sun path")));
    }
    if let Some(regions) = regions::manifest(&args.file)? {
        args.run.memory_limit().check_regions(&regions, &args.file)?;
        let sampler = regions::sampler(&regions, &args.file, &args.lookup, level.level)?;
        let points = args.read()?;
        return args.answer(&points, &sampler, None);
    }
    let file = level.of(&args.run.memory_limit().read_shadow_file(&args.file)?, &args.file)?;
    let points = args.read()?;
    args.answer(&points, &args.lookup.sampler(&file)?, None)
}
