//! Options of `report`.

use std::path::PathBuf;

use adumbra_program::args::parse_size;
use adumbra_program::exit::Failure;

/// The sections of a report in their order: name and title.
pub(crate) const SECTIONS: [(&str, &str); 9] = [
    ("bake", "Bakes: time, memory, file size"),
    ("verify", "Files compared with rays"),
    ("tree", "The world-aligned tree"),
    ("hrsm", "Hybrid-resolution shadow maps"),
    ("blur", "The screen-space blur"),
    ("shadows", "Shadow techniques compared with ray-traced truth"),
    ("ao", "Ambient occlusion compared with rays"),
    ("peers", "Compared with current engines"),
    ("fast", "Requirements on the fast bake"),
];

/// Options of `report`.
#[derive(clap::Args)]
pub struct Report {
    /// Folder for report.html, report.json, the generated scenes and all measurements
    #[arg(short, long, value_name = "DIR")]
    pub(crate) output: PathBuf,
    /// Use small sizes; takes under ten minutes on two cores and needs no input files [default]
    #[arg(long, conflicts_with = "full")]
    pub(crate) quick: bool,
    /// Run every benchmark at its defaults; takes hours and needs --scenes and --truth
    #[arg(long)]
    pub(crate) full: bool,
    /// Folder of scenes; a quick run uses a few of them instead of generated scenes
    #[arg(long, value_name = "DIR")]
    pub(crate) scenes: Option<PathBuf>,
    /// Folder of truth files, for the comparison with current engines
    #[arg(long, value_name = "DIR", requires = "scenes")]
    pub(crate) truth: Option<PathBuf>,
    /// Measure only these sections, and keep the others of an earlier report in the folder
    #[arg(long, value_name = "SECTION", value_delimiter = ',', value_parser = SECTIONS.map(|(name, _)| name))]
    pub(crate) only: Vec<String>,
    /// Size of the pictures of a quick run in pixels
    #[arg(long, value_name = "WxH", default_value = "640x360", value_parser = parse_size, conflicts_with = "full")]
    pub(crate) size: [u32; 2],
    /// Print report.json too
    #[arg(long)]
    pub(crate) json: bool,
}

impl Report {
    /// Checks that the options fit together and that the given folders exist.
    ///
    /// # Errors
    /// Returns [`Failure::Usage`] if they do not.
    pub(crate) fn check(&self) -> Result<(), Failure> {
        if self.full && (self.scenes.is_none() || self.truth.is_none()) {
            let text = "--full: also give --scenes and --truth, the folders that the benchmarks read";
            return Err(Failure::Usage(text.to_owned()));
        }
        if self.size.iter().any(|s| *s < 32) {
            return Err(Failure::Usage("--size: give at least 32 pixels per side".to_owned()));
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
                return Err(Failure::Usage(format!("--only {name}: this section needs {needs}")));
            }
        }
        Ok(())
    }
}
