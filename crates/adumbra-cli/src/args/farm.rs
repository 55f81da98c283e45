//! Arguments of `plan`, `tile` and `link`.

use std::path::PathBuf;
use std::str::FromStr;

use adumbra_program::args::{RunArgs, SceneArgs};
use adumbra_program::progress::Style;
use clap::ValueEnum;

use super::bake::BakeSettings;
use super::shard::Shard;

#[derive(clap::Args)]
pub(crate) struct Plan {
    /// Scene: .glb, .gltf, .obj or .ply
    pub(crate) scene: PathBuf,
    #[command(flatten)]
    pub(crate) settings: BakeSettings,
    #[command(flatten)]
    pub(crate) load: SceneArgs,
    /// The plan to write [default: the scene's path with the extension .plan.json]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Also write a job beside the plan that bakes its parts and links them
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(crate) export: Option<ExportFormat>,
    /// Number of tasks of the job that bake parts
    #[arg(long, value_name = "N", default_value_t = 64, requires = "export", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) shards: u32,
    /// Folder or URL of the job's bake cache [default: the plan's path with the extension .cache]
    #[arg(long, value_name = "DIR|URL", requires = "export")]
    pub(crate) cache: Option<PathBuf>,
    /// The shadow file of the job [default: the scene's path with the extension .adumbra]
    #[arg(long, value_name = "FILE", requires = "export")]
    pub(crate) shadow_file: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// A kind of job.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExportFormat {
    /// A job template of Open Job Description, for render farms: FILE.yaml
    Openjd,
    /// A script that submits an array job and a job after it: FILE.slurm.sh
    Slurm,
    /// A makefile, for make -j: FILE.mk
    Make,
}

#[derive(clap::Args)]
pub(crate) struct Tile {
    /// The plan
    #[arg(long, value_name = "FILE")]
    pub(crate) plan: PathBuf,
    /// Bake one of N shares of the parts, from 0/N to N-1/N
    #[arg(long, value_name = "I/N", conflicts_with = "ids")]
    pub(crate) shard: Option<Shard>,
    /// Bake these parts, such as 0,5,7-9
    #[arg(long, value_name = "IDS")]
    pub(crate) ids: Option<Ids>,
    /// Folder or URL of the bake cache [default: the plan's path with the extension .cache]
    #[arg(long, value_name = "DIR|URL")]
    pub(crate) cache: Option<PathBuf>,
    /// The scene that was planned, if it has another path here
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: Option<PathBuf>,
    /// How to show progress
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) progress: Style,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[derive(clap::Args)]
pub(crate) struct Link {
    /// The plan
    #[arg(long, value_name = "FILE")]
    pub(crate) plan: PathBuf,
    /// Folder or URL of the bake cache [default: the plan's path with the extension .cache]
    #[arg(long, value_name = "DIR|URL")]
    pub(crate) cache: Option<PathBuf>,
    /// The shadow file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Ids of parts: from the first to the last of each range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Ids {
    ranges: Vec<[usize; 2]>,
}

impl Ids {
    /// Returns the ids, at most up to the first one that is `end` or more, which no plan of `end` parts has.
    pub(crate) fn within(&self, end: usize) -> impl Iterator<Item = usize> {
        self.ranges.iter().flat_map(move |&[first, last]| first..=last.min(end.max(first)))
    }
}

impl FromStr for Ids {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let range = |text: &str| {
            let (first, last) = text.split_once('-').unwrap_or((text, text));
            let [first, last] = [first.trim().parse().ok()?, last.trim().parse().ok()?];
            (first <= last).then_some([first, last])
        };
        let ranges: Option<Vec<_>> = text.split(',').map(range).collect();
        ranges
            .map(|ranges| Self { ranges })
            .ok_or_else(|| "give numbers and ranges such as 0,5,7-9".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_ids() {
        let ids = |text: &str, end| text.parse::<Ids>().map(|ids| ids.within(end).collect::<Vec<_>>());
        assert_eq!(ids("0,5,7-9", 100), Ok(vec![0, 5, 7, 8, 9]));
        assert_eq!(ids("3-99999999999", 5), Ok(vec![3, 4, 5]));
        assert_eq!(ids("8", 5), Ok(vec![8]));
        for wrong in ["", ",", "1-", "9-7", "x", "1;2"] {
            assert!(ids(wrong, 100).is_err(), "{wrong}");
        }
    }
}
