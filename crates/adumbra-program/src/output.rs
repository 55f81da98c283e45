//! Files that the programs write next to the shadow file, completely or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use adumbra::IoError;
use adumbra_files::{StagedFile, first_same, folder_of, same_file};
use adumbra_scene::LoadNotes;
use adumbra_truth::picture::Picture;
use image::ImageEncoder;
use serde::Serialize;

use crate::exit::Failure;

/// Files that belong together: all of them are written before any of them replaces an existing file.
#[derive(Default)]
pub struct Outputs(Vec<StagedFile>);

impl Outputs {
    /// Writes `bytes` to a temporary file next to `path`, unless this run has read the file at `path`.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if this run has read the file at `path`, or if it cannot be written.
    pub fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        refuse_read("output", path)?;
        self.0.push(StagedFile::new(path, |file| file.write_all(bytes).map(|()| bytes.len() as u64))?);
        Ok(())
    }

    /// Encodes a picture as PNG and adds it like [`Self::add`].
    ///
    /// # Errors
    ///
    /// Returns the errors of [`Self::add`], and [`Failure::BadInput`] if the picture cannot be encoded.
    pub fn add_png(&mut self, path: &Path, picture: &Picture) -> Result<(), Failure> {
        self.add(path, &png(path, picture)?)
    }

    /// Renames all files to their final paths, unless two of the paths are one file.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if two paths are one file, or if a file cannot be renamed.
    pub fn place(self) -> Result<(), Failure> {
        refuse_same(self.0.iter().map(StagedFile::path))?;
        Ok(StagedFile::place(self.0)?)
    }
}

/// Refuses two outputs that are one file, whatever their spelling and through whichever links: the later
/// would replace the earlier.
///
/// # Errors
///
/// Returns [`Failure::Usage`] if two of them are one file. The error names both.
pub fn refuse_same<'p>(outputs: impl IntoIterator<Item = &'p Path>) -> Result<(), Failure> {
    match first_same(outputs) {
        Some((first, second)) => Err(Failure::Usage(format!(
            "the outputs {} and {} are one file; remove the link, or give another path",
            first.display(),
            second.display()
        ))),
        None => Ok(()),
    }
}

/// Writes `bytes` to `path`, unless this run has read the file there.
///
/// # Errors
///
/// Returns [`Failure`] if this run has read the file at `path`, or if it cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let mut outputs = Outputs::default();
    outputs.add(path, bytes)?;
    outputs.place()
}

/// Writes a picture as PNG to `path`.
///
/// # Errors
///
/// Returns the errors of [`write_whole`], and [`Failure::BadInput`] if the picture cannot be encoded.
pub fn write_png(path: &Path, picture: &Picture) -> Result<(), Failure> {
    write_whole(path, &png(path, picture)?)
}

/// Returns a picture encoded as PNG. `path` is only for the error.
///
/// # Errors
///
/// Returns [`Failure::BadInput`] if the number of the picture's bytes does not match its size.
pub fn png(path: &Path, picture: &Picture) -> Result<Vec<u8>, Failure> {
    let Picture { width, height, ref rgb, .. } = *picture;
    let cannot = |what: String| {
        let path = path.display();
        Failure::BadInput(format!("{path}: cannot encode a picture of {width} x {height} pixels: {what}"))
    };
    if rgb.len() as u64 != 3 * u64::from(width) * u64::from(height) {
        return Err(cannot(format!("it has {} bytes", rgb.len())));
    }
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|e| cannot(e.to_string()))?;
    Ok(bytes)
}

/// Refuses an output that a verb also reads, whatever its spelling and through whichever links. `option` is
/// the option that gave its path. Each input has a name for the error.
///
/// # Errors
///
/// Returns [`Failure::Usage`] if the output is an input. The error names it.
pub fn refuse_inputs<'p>(
    option: &str,
    output: &Path,
    inputs: impl IntoIterator<Item = (&'static str, &'p Path)>,
) -> Result<(), Failure> {
    match inputs.into_iter().find(|(_, input)| same_file(output, input)) {
        Some((what, input)) => Err(is_input(option, output, what, input)),
        None => Ok(()),
    }
}

fn is_input(option: &str, output: &Path, what: &str, input: &Path) -> Failure {
    let output = output.display().to_string();
    let input = input.display().to_string();
    let place = if input == output { String::new() } else { format!(", {input}") };
    Failure::Usage(format!("{option} {output}: it would overwrite {what}{place}; give another path"))
}

/// A file that this run has read.
#[derive(Clone, PartialEq)]
struct Read {
    what: &'static str,
    path: PathBuf,
    /// For a scene, the files that it names, with paths relative to its folder.
    named_files: Vec<PathBuf>,
}

/// All files that this run has read.
static READ: Mutex<Vec<Read>> = Mutex::new(Vec::new());

/// Records a file that this run reads, so that no later output of the run replaces it.
pub fn note_input(what: &'static str, path: &Path) {
    note(Read { what, path: path.to_owned(), named_files: Vec::new() });
}

/// Records a scene like [`note_input`], and also the files that its loader found it to name.
pub(crate) fn note_scene(path: &Path, notes: &LoadNotes) {
    note(Read { what: SCENE, path: path.to_owned(), named_files: notes.named_files.clone() });
}

fn note(new: Read) {
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    if !read.contains(&new) {
        read.push(new);
    }
}

/// Name of a scene in errors about outputs that would replace it.
pub const SCENE: &str = "the scene itself";

/// Refuses an output that would replace a file that this run has read, or one that a scene names. `option` is
/// the option that gave its path.
///
/// # Errors
///
/// Returns [`Failure::Usage`] if the output is such a file. The error names it.
pub fn refuse_read(option: &str, output: &Path) -> Result<(), Failure> {
    // A file that does not exist yet cannot have been read.
    if !output.exists() {
        return Ok(());
    }
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    read.iter().try_for_each(|Read { what, path, named_files }| {
        refuse_inputs(option, output, [(*what, &**path)])?;
        let folder = folder_of(path);
        let mut named = named_files.iter().map(|name| folder.join(name));
        named.try_for_each(|path| refuse_inputs(option, output, [("a file that the scene names", &*path)]))
    })
}

/// Creates a folder and its parents.
///
/// # Errors
///
/// Returns [`Failure::Io`] if it cannot be created.
pub fn make_folder(path: &Path) -> Result<(), Failure> {
    Ok(std::fs::create_dir_all(path).map_err(IoError::at("create", path))?)
}

/// Formats a number of any size: with four decimals, or with an exponent if it is very large or very small.
pub fn format_number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e9).contains(&value.abs()) {
        format!("{value:.4}")
    } else {
        format!("{value:.3e}")
    }
}

/// Formats a number of bytes, for example 12,345,678 as "11.8 MiB".
pub fn format_bytes(bytes: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{bytes} B") } else { format!("{value:.1} {}", units[unit]) }
}

/// Prints a JSON document in one line.
///
/// # Errors
///
/// Returns [`Failure::BadInput`] if the document cannot be written as JSON.
pub fn print_json_line(document: &impl Serialize) -> Result<(), Failure> {
    let value = serde_json::to_value(document).map_err(|e| Failure::BadInput(e.to_string()))?;
    crate::say!("{value}");
    Ok(())
}

/// Prints a JSON document on stdout with its keys in alphabetical order.
///
/// # Errors
///
/// Returns [`Failure::BadInput`] if the document cannot be represented as JSON.
pub fn print_json(document: &impl Serialize) -> Result<(), Failure> {
    let value = serde_json::to_value(document).map_err(|e| Failure::BadInput(e.to_string()))?;
    crate::say!("{value:#}");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_round_trips_pixels_and_names_a_file_that_it_cannot_be() {
        let mut picture =
            Picture { width: 2, height: 1, rgb: vec![1, 2, 3, 4, 5, 6], difference_share: None };
        let bytes = png(Path::new("a.png"), &picture).unwrap();
        assert_eq!(image::load_from_memory(&bytes).unwrap().into_rgb8().into_raw(), picture.rgb);
        picture.rgb.pop();
        let fault = png(Path::new("a.png"), &picture).unwrap_err().to_string();
        assert_eq!(fault, "a.png: cannot encode a picture of 2 x 1 pixels: it has 5 bytes");
    }
}
