//! The formats of outputs, by the suffixes of their names.

use std::path::Path;

use adumbra_files::check_output;
use adumbra_program::exit::Failure;
use adumbra_program::output::{SCENE, refuse_inputs, refuse_same};

use crate::args::PointArgs;

/// A format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Csv,
    Html,
    Json,
    Ply,
    Png,
    Tiff,
}

impl Format {
    /// Formats that hold points.
    pub(super) const OF_POINTS: &[Self] = &[Self::Csv, Self::Ply, Self::Json];
    /// Formats that also hold grids.
    pub(super) const OF_GRIDS: &[Self] =
        &[Self::Csv, Self::Ply, Self::Json, Self::Png, Self::Tiff, Self::Html];
    /// Formats of the sky.
    pub(super) const OF_SKIES: &[Self] = &[Self::Csv, Self::Json];

    fn suffix(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Html => "html",
            Self::Json => "json",
            Self::Ply => "ply",
            Self::Png => "png",
            Self::Tiff => "tif",
        }
    }

    /// Returns the format that the suffix of a path names, if it is one of these.
    pub(super) fn of(path: &Path, accepted: &[Self]) -> Result<Self, Failure> {
        let suffix = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        let suffix = if suffix == "tiff" { "tif".to_owned() } else { suffix };
        let found = Self::OF_GRIDS.iter().copied().find(|format| format.suffix() == suffix);
        match found {
            Some(format) if accepted.contains(&format) => Ok(format),
            Some(format) if Self::OF_GRIDS.contains(&format) && accepted == Self::OF_POINTS => {
                Err(Failure::Usage(format!("--output {}: .{suffix} needs --grid", path.display())))
            }
            _ => {
                let names: Vec<String> =
                    accepted.iter().map(|format| format!(".{}", format.suffix())).collect();
                Err(Failure::Usage(format!(
                    "--output {}: its suffix says no format; give one of {}",
                    path.display(),
                    names.join(", ")
                )))
            }
        }
    }
}

/// Returns the format of each output. Outputs that would replace an input, or each other, are refused before
/// any work.
pub(super) fn outputs<'p>(
    outputs: &'p [std::path::PathBuf],
    accepted: &[Format],
    scenes: &[&Path],
    points: &PointArgs,
) -> Result<Vec<(&'p Path, Format)>, Failure> {
    refuse_same(outputs.iter().map(|path| &**path))?;
    let checked = |path: &'p std::path::PathBuf| {
        let format = Format::of(path, accepted)?;
        let table = points.places.points.iter().map(|table| ("the points", &**table));
        refuse_inputs("--output", path, scenes.iter().map(|scene| (SCENE, *scene)).chain(table))?;
        check_output(path)?;
        Ok((&**path, format))
    };
    outputs.iter().map(checked).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suffix_selects_the_format() {
        let of = |name: &str, accepted| Format::of(Path::new(name), accepted);
        assert_eq!(of("a.b/c.CSV", Format::OF_SKIES).ok(), Some(Format::Csv));
        assert_eq!(of("a.tiff", Format::OF_GRIDS).ok(), Some(Format::Tiff));
        for (name, accepted, message) in [
            ("a", Format::OF_GRIDS, "give one of .csv, .ply, .json, .png, .tif, .html"),
            ("a.png", Format::OF_POINTS, ".png needs --grid"),
            ("a.ply", Format::OF_SKIES, "give one of .csv, .json"),
        ] {
            let error = of(name, accepted).map(|_| ()).unwrap_err().to_string();
            assert!(error.contains(message), "{name}: {error}");
        }
    }
}
