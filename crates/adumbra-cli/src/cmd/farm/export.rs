//! Writes jobs that bake the parts of a plan and link them, for existing schedulers.
//!
//! The templates are in `jobs/`. Each mark in them, such as `@PLAN@`, is replaced by a value in the
//! scheduler's own quotes.

use std::io::Write;
use std::path::{Path, PathBuf};

use adumbra_files::{check_output, folder_of, replace_file};
use adumbra_program::args::quoted;
use adumbra_program::exit::Failure;

use crate::args::ExportFormat;
use crate::cmd::store::url_of;

/// The inputs of a job. All paths are absolute; the place of the entries may be a URL.
pub(super) struct Job<'p> {
    pub(super) format: ExportFormat,
    /// The program `adumbra`.
    pub(super) program: &'p Path,
    pub(super) plan: &'p Path,
    pub(super) cache: &'p Path,
    pub(super) shadow_file: &'p Path,
    pub(super) shards: u32,
    /// Number of threads of each task, unless it takes all cores.
    pub(super) threads: Option<u16>,
}

impl Job<'_> {
    /// Returns where the job is written: beside the plan.
    pub(super) fn path(&self) -> PathBuf {
        self.plan.with_extension(match self.format {
            ExportFormat::Openjd => "yaml",
            ExportFormat::Slurm => "slurm.sh",
            ExportFormat::Make => "mk",
        })
    }

    /// Writes the job.
    pub(super) fn write(&self) -> Result<PathBuf, Failure> {
        let path = self.path();
        check_output(&path)?;
        let text = match self.format {
            ExportFormat::Openjd => self.openjd()?,
            ExportFormat::Slurm => self.filled(include_str!("jobs/slurm.sh"), quoted)?,
            ExportFormat::Make => self.filled(include_str!("jobs/make.mk"), quoted_for_make)?,
        };
        replace_file(&path, |out| out.write_all(text.as_bytes()).map(|()| text.len() as u64))?;
        Ok(path)
    }

    fn filled(&self, template: &str, quote: impl Fn(&str) -> String) -> Result<String, Failure> {
        let paths = [
            ("@PROGRAM@", self.program),
            ("@PLAN@", self.plan),
            ("@CACHE@", self.cache),
            ("@OUTPUT@", self.shadow_file),
        ];
        let mut values = vec![("@SHARDS@", self.shards.to_string()), ("@THREADS@", self.threads_option())];
        for (mark, path) in paths {
            values.push((mark, quote(text_of(path)?)));
        }
        Ok(with_values(template, &values))
    }

    fn openjd(&self) -> Result<String, Failure> {
        let folder = folder_of(self.plan);
        // A template may have defaults only for files below its own folder; the job asks for other files.
        let default = |path: &Path| -> Result<String, Failure> {
            path.strip_prefix(&folder).map_or_else(
                |_| Ok(String::new()),
                |below| Ok(format!("default: {}", as_json(text_of(below)?))),
            )
        };
        let (cache_type, cache) = match url_of(self.cache) {
            Some(url) => ("type: STRING", format!("default: {}", as_json(url))),
            None => ("type: PATH\n    objectType: DIRECTORY\n    dataFlow: INOUT", default(self.cache)?),
        };
        let values = [
            ("@NAME@", as_json("adumbra bake")),
            ("@PROGRAM@", as_json(text_of(self.program)?)),
            ("@PLAN_DEFAULT@", default(self.plan)?),
            ("@CACHE_TYPE@", cache_type.to_owned()),
            ("@CACHE_DEFAULT@", cache),
            ("@OUTPUT_DEFAULT@", default(self.shadow_file)?),
            ("@SHARDS@", self.shards.to_string()),
            ("@THREADS@", self.threads_option()),
        ];
        let text = with_values(include_str!("jobs/openjd.yaml"), &values);
        Ok(text.lines().filter(|line| !line.trim().is_empty()).flat_map(|line| [line, "\n"]).collect())
    }

    fn threads_option(&self) -> String {
        self.threads.map_or_else(String::new, |threads| format!(" --threads {threads}"))
    }
}

/// Replaces all marks in one pass over the template, so that marks inside values are not replaced.
fn with_values(template: &str, values: &[(&str, String)]) -> String {
    let mut text = String::with_capacity(template.len());
    let mut rest = template;
    while let Some((at, mark, value)) = values
        .iter()
        .filter_map(|(mark, value)| rest.find(mark).map(|at| (at, mark, value)))
        .min_by_key(|(at, ..)| *at)
    {
        text.push_str(&rest[..at]);
        text.push_str(value);
        rest = &rest[at + mark.len()..];
    }
    text + rest
}

fn text_of(path: &Path) -> Result<&str, Failure> {
    let text = path.to_str().filter(|text| !text.contains(['\n', '\r', '\0']));
    text.ok_or_else(|| {
        Failure::Usage(format!(
            "{}: a job cannot name a path with such characters; rename it",
            path.display()
        ))
    })
}

fn as_json(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// Quotes a text as the value of a variable in a makefile.
fn quoted_for_make(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '#' => {
                // Backslashes before # are read in pairs.
                let before = out.len() - out.trim_end_matches('\\').len();
                out.push_str(&"\\".repeat(before + 1));
                out.push('#');
            }
            '$' => out.push_str("$$"),
            other => out.push(other),
        }
    }
    if out.ends_with('\\') {
        out.push_str("$(empty)");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_inside_values_are_not_replaced() {
        let values = [("@A@", "@B@".to_owned()), ("@B@", "b".to_owned())];
        assert_eq!(with_values("x @A@ @B@ @A@", &values), "x @B@ b @B@");
    }

    #[test]
    fn quotes_characters_that_make_interprets() {
        for (text, expected) in
            [("a b", "a b"), ("a#b", "a\\#b"), ("a\\#b", "a\\\\\\#b"), ("$x", "$$x"), ("a\\", "a\\$(empty)")]
        {
            assert_eq!(quoted_for_make(text), expected);
        }
    }
}
