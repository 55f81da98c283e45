//! `adumbra verify`: compares a file's answers with rays.

use adumbra::regions::Regions;
use adumbra::{FileSettings, Filter};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::moment;
use adumbra_program::output::print_json;
use adumbra_program::verify::{Verified, VerifiedScene, Verify};
use adumbra_scene::{Casters, LoadedAs};
use adumbra_truth::verify::{LightAnswers, VolumeSampler};
use schemars::JsonSchema;
use serde::Serialize;

use super::path::{self, VerifiedPath};
use super::regions;
use crate::args::VerifyFile;

/// What is printed with `--json`.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Printed {
    /// Of a shadow file, or a manifest of regions.
    #[expect(dead_code, reason = "what compares a file prints it")]
    File(VerifiedScene),
    /// Of a sun path.
    Path(VerifiedPath),
}

pub(crate) fn run(VerifyFile { verify: args, level, path: of_path }: &VerifyFile) -> Outcome {
    if let Some(sun_path) = moment::sun_path(&args.file)? {
        let verified = path::verify(args, of_path, &sun_path)?;
        let code = if verified.ok { Code::Fine } else { Code::CheckFailed };
        if args.run.json {
            print_json(&Printed::Path(verified))?;
        }
        return Ok(code);
    }
    if let Some(regions) = regions::manifest(&args.file)? {
        return run_regions(args, &regions, level.level);
    }
    let file = level.of(&args.run.memory_limit().read_shadow_file(&args.file)?, &args.file)?;
    if let Some(region) = file.settings.region {
        return Err(Failure::Usage(format!(
            "{} is the file of region ({}, {}) of a world; verify the world's manifest",
            args.file.display(),
            region.x,
            region.y
        )));
    }
    refuse_volume(args, &file.settings)?;
    let verified = Verified {
        sun: file.sun(),
        voxel_size: file.grid.voxel_size,
        is_finest: level.level == 0,
        scene: LoadedAs::from(&file.settings),
        assumes_ground: file.settings.assume_ground,
        casters: Some(Casters { triangles: file.settings.triangles, instances: file.settings.instances }),
        volume: VolumeSampler::new(&file.grid),
    };
    args.compare(verified, &LightAnswers::of(&file, args.lookup.sampler(&file)?))
}

/// Verifies all regions of a world as one.
fn run_regions(args: &Verify, regions: &Regions, level: u32) -> Outcome {
    args.run.memory_limit().check_regions(regions, &args.file)?;
    let sampler = regions::sampler(regions, &args.file, &args.lookup, level)?;
    let Some(&settings) = sampler.settings() else {
        return Err(Failure::BadInput(format!(
            "{} has no regions, so there is nothing to verify",
            args.file.display()
        )));
    };
    refuse_volume(args, &settings)?;
    let grid = *sampler.grid();
    let verified = Verified {
        sun: grid.sun,
        voxel_size: grid.voxel_size,
        is_finest: level == 0,
        scene: LoadedAs::from(&settings),
        assumes_ground: settings.assume_ground,
        casters: None,
        volume: VolumeSampler::new(&grid),
    };
    let asked = (Filter::try_from(args.lookup.filter)?, args.lookup.bias.over(settings.bias)?);
    args.compare(verified, &LightAnswers::new(grid, settings, sampler, asked))
}

/// Refuses points in free space of a file that promises nothing there.
fn refuse_volume(args: &Verify, settings: &FileSettings) -> Result<(), Failure> {
    if args.volume && settings.assume_ground {
        return Err(Failure::Usage(format!(
            "{} was baked with ground assumed, so it promises nothing about points in free space; bake with --assume-ground no",
            args.file.display()
        )));
    }
    Ok(())
}
