//! `adumbra verify`: compares a file's answers with rays.

use adumbra::ShadowFile;
use adumbra_program::exit::{Failure, Outcome};
use adumbra_program::verify::Verified;
use adumbra_truth::verify::{LightAnswers, VolumeSampler};

use crate::args::VerifyFile;

pub(crate) fn run(VerifyFile { verify: args, level }: &VerifyFile) -> Outcome {
    args.check_file_memory()?;
    let file = level.of(&ShadowFile::read(&args.file)?, &args.file)?;
    if args.volume && file.settings.assume_ground {
        return Err(Failure::Usage(format!(
            "{} was baked with ground assumed, so it promises nothing about points in free space; bake with --no-assume-ground",
            args.file.display()
        )));
    }
    let verified = Verified {
        sun: file.sun(),
        voxel_size: file.grid.voxel_size,
        ignores_alpha: file.ignores_alpha(),
        volume: VolumeSampler::new(&file.grid),
    };
    args.compare(verified, &LightAnswers::of(&file, args.lookup.sampler(&file)?))
}
