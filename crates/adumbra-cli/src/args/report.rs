//! Arguments of `report`.

use std::path::PathBuf;

use super::parse_size;
use crate::exit::Failure;

/// What a report measures, in this order: name, and what it is.
pub(crate) const SECTIONS: [(&str, &str); 9] = [
    ("bake", "Bakes: seconds, memory, bytes"),
    ("verify", "Files against rays"),
    ("tree", "The world-aligned tree"),
    ("hrsm", "Hybrid-resolution shadow maps"),
    ("blur", "The screen-space blur"),
    ("shadows", "Shadow techniques beside the truth"),
    ("ao", "Ambient occlusion beside rays"),
    ("peers", "Beside today's engines"),
    ("fast", "What the fast bake is held to"),
];

#[derive(clap::Args)]
pub(crate) struct Report {
    /// Folder for report.html, report.json, the scenes that are made and all that is measured
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Small sizes: under ten minutes on two cores, and no files are needed [default]
    #[arg(long, conflicts_with = "full")]
    pub(crate) quick: bool,
    /// Every benchmark at its defaults: hours; needs --scenes and --truth
    #[arg(long)]
    pub(crate) full: bool,
    /// Folder of scenes; a quick run takes from it what it has time for, in place of scenes that are made
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: Option<PathBuf>,
    /// Folder of truth files, for the tables beside today's engines
    #[arg(long, value_name = "DIR", requires = "scenes")]
    pub(crate) truth: Option<PathBuf>,
    /// Measure these sections only, and keep the others of an earlier report in the folder
    #[arg(long, value_name = "SECTION", value_delimiter = ',', value_parser = SECTIONS.map(|(name, _)| name))]
    pub(crate) only: Vec<String>,
    /// Of a quick run's pictures: pixels
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = parse_size, conflicts_with = "full")]
    pub(crate) size: [u32; 2],
    /// Print report.json too
    #[arg(long)]
    pub(crate) json: bool,
}

impl Report {
    /// Whether what was asked for is there.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        if self.full && (self.scenes.is_none() || self.truth.is_none()) {
            let text =
                "--full: give --scenes and --truth, the folders that the benchmarks' defaults speak of";
            return Err(Failure::Usage(text.to_owned()));
        }
        if self.size.iter().any(|s| *s < 32) {
            return Err(Failure::Usage("--size: give 32 pixels a side or more".to_owned()));
        }
        for (option, folder) in [("--scenes", &self.scenes), ("--truth", &self.truth)] {
            if let Some(folder) = folder.as_ref().filter(|f| !f.is_dir()) {
                return Err(Failure::Usage(format!("{option} {}: no such folder", folder.display())));
            }
        }
        for (name, needs, given) in
            [("peers", "--scenes and --truth", self.truth.is_some()), ("fast", "--full", self.full)]
        {
            if !given && self.only.iter().any(|only| only == name) {
                return Err(Failure::Usage(format!("--only {name}: it needs {needs}")));
            }
        }
        Ok(())
    }
}
