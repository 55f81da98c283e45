//! Files the program writes beside the shadow file: whole or not at all.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use adumbra::Error;
use adumbra::files::{StagedFile, first_same, folder_of, same_file};
use adumbra::picture::Picture;
use adumbra::scene::LoadNotes;
use image::ImageEncoder;

use crate::exit::Failure;

/// Files that belong together: all of them are written before any replaces what was there.
#[derive(Default)]
pub(crate) struct Outputs(Vec<StagedFile>);

impl Outputs {
    /// Writes `bytes` beside `path`, unless a file that this run has read lies there.
    pub(crate) fn add(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        refuse_read("output", path)?;
        self.0.push(StagedFile::new(path, |file| file.write_all(bytes).map(|()| bytes.len() as u64))?);
        Ok(())
    }

    /// [`Self::add`] for a picture, as PNG.
    pub(crate) fn add_png(&mut self, path: &Path, picture: &Picture) -> Result<(), Failure> {
        self.add(path, &png(path, picture)?)
    }

    /// Gives all files their names, unless two of them are one file.
    pub(crate) fn place(self) -> Result<(), Failure> {
        refuse_same(self.0.iter().map(StagedFile::path))?;
        Ok(StagedFile::place(self.0)?)
    }
}

/// Refuses two outputs that are one file, under whatever spelling and through whichever links: the later would replace the earlier.
pub(crate) fn refuse_same<'p>(outputs: impl IntoIterator<Item = &'p Path>) -> Result<(), Failure> {
    match first_same(outputs) {
        Some((first, second)) => Err(Failure::Usage(format!(
            "{} and {} are both written, and are one file; remove the link, or give another path",
            first.display(),
            second.display()
        ))),
        None => Ok(()),
    }
}

/// Writes `bytes` at `path`, unless a file that this run has read lies there.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let mut outputs = Outputs::default();
    outputs.add(path, bytes)?;
    outputs.place()
}

/// Writes a picture as PNG.
pub(crate) fn write_png(path: &Path, picture: &Picture) -> Result<(), Failure> {
    write_whole(path, &png(path, picture)?)
}

/// A picture as PNG, to go to `path`.
fn png(path: &Path, picture: &Picture) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&picture.rgb, picture.width, picture.height, image::ExtendedColorType::Rgb8)
        .map_err(|e| Failure::BadInput(format!("{}: cannot encode the picture: {e}", path.display())))?;
    Ok(bytes)
}

/// Writes named channels of 32-bit floats as OpenEXR, without loss.
pub(crate) fn write_exr(path: &Path, size: [u32; 2], channels: &[(&str, Vec<f32>)]) -> Result<(), Failure> {
    use exr::prelude::*;
    let list = channels
        .iter()
        .map(|(name, values)| AnyChannel::new(*name, FlatSamples::F32(values.clone())))
        .collect();
    let image = Image::from_layer(Layer::new(
        (size[0] as usize, size[1] as usize),
        LayerAttributes::default(),
        Encoding::SMALL_FAST_LOSSLESS,
        AnyChannels::sort(list),
    ));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| Failure::BadInput(format!("{}: cannot encode the picture: {e}", path.display())))?;
    write_whole(path, bytes.get_ref())
}

/// Refuses an output that a verb also reads, under whatever spelling and through whichever links. `option` is where its path was given;
/// each input has a name.
pub(crate) fn refuse_inputs<'p>(
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
    Failure::Usage(format!("{option} {output}: it is {what}{place}; give another path"))
}

/// A file that this run has read.
#[derive(Clone, PartialEq)]
struct Read {
    what: &'static str,
    path: PathBuf,
    /// Of a scene, the files that it names, as they are found from its folder.
    named_files: Vec<PathBuf>,
}

/// Files that this run has read.
static READ: Mutex<Vec<Read>> = Mutex::new(Vec::new());

/// Remembers a file that this run reads, so that nothing that it writes later replaces it.
pub(crate) fn note_input(what: &'static str, path: &Path) {
    note(Read { what, path: path.to_owned(), named_files: Vec::new() });
}

/// [`note_input`] for a scene, and for the files that it names, which its loader has found.
pub(crate) fn note_scene(path: &Path, notes: &LoadNotes) {
    note(Read { what: SCENE, path: path.to_owned(), named_files: notes.named_files.clone() });
}

fn note(new: Read) {
    let mut read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    if !read.contains(&new) {
        read.push(new);
    }
}

/// What a scene is called where an output would replace it.
pub(crate) const SCENE: &str = "the scene itself";

/// Refuses an output that would replace a file that this run has read, or one that a scene names. `option` is
/// where its path was given.
pub(crate) fn refuse_read(option: &str, output: &Path) -> Result<(), Failure> {
    // A file that is not there yet is none that was read.
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

/// Makes a folder and its parents.
pub(crate) fn make_folder(path: &Path) -> Result<(), Failure> {
    Ok(std::fs::create_dir_all(path).map_err(Error::io("create", path))?)
}

/// 12,345,678 as "11.8 MiB".
pub(crate) fn bytes_words(bytes: u64) -> String {
    let units = ["B", "KiB", "MiB", "GiB", "TiB"];
    let mut value = bytes as f64;
    let mut unit = 0;
    while value >= 1024.0 && unit + 1 < units.len() {
        value /= 1024.0;
        unit += 1;
    }
    if unit == 0 { format!("{bytes} B") } else { format!("{value:.1} {}", units[unit]) }
}
