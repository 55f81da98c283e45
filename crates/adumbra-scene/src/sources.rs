//! The files of a scene: the scene itself, and the buffers, images and material libraries it references.
//!
//! Scenes may be untrusted. A referenced file must be in the scene's own folder unless the caller allows
//! more. Only regular files are read, and no more of them than their stated length.

use adumbra::IoError;
use std::cell::{OnceCell, RefCell};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

use hashbrown::HashSet;

use crate::budget::Budget;
use crate::{Error, LoadOptions, Result};

/// Maximum size of a material library, bytes.
pub(super) const MAX_LIBRARY_BYTES: u64 = 256 << 20;
/// Maximum size of an image file, bytes.
pub(super) const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// Memory for remembering a file, in addition to its name, bytes.
const NAME_BYTES: u64 = 80;

/// Reads the files of a scene and limits how much of them may be held in memory.
pub(super) struct Sources<'a> {
    /// The scene file.
    pub(super) scene: &'a Path,
    /// The memory budget of the load.
    pub(super) budget: Budget<'a>,
    /// "glTF", "OBJ" or "PLY".
    format: &'static str,
    allow_outside: bool,
    folder: OnceCell<PathBuf>,
    known: RefCell<HashSet<PathBuf>>,
    named: RefCell<HashSet<PathBuf>>,
}

/// A regular file that a scene may read, with all links resolved.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Located(PathBuf);

impl<'a> Sources<'a> {
    pub(super) fn new(scene: &'a Path, format: &'static str, options: &LoadOptions) -> Self {
        Self {
            scene,
            budget: Budget::new(scene, options.max_memory_bytes),
            format,
            allow_outside: options.allow_outside,
            folder: OnceCell::new(),
            known: RefCell::default(),
            named: RefCell::default(),
        }
    }

    /// Reads the whole scene file; an empty file is an error.
    pub(super) fn read_scene(&self) -> Result<Vec<u8>> {
        let bytes = self.read_regular(self.scene, "the scene", u64::MAX)?;
        if bytes.is_empty() {
            return Err(self.bad("the file is empty"));
        }
        Ok(bytes)
    }

    /// Records a file that the scene references, whether it is read or not, for
    /// [`LoadNotes::named_files`](crate::LoadNotes::named_files).
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`] if the name does not fit the memory budget.
    pub(super) fn note_named(&self, named: impl AsRef<Path>) -> Result<()> {
        let named = named.as_ref();
        let mut known = self.named.borrow_mut();
        if !known.contains(named) {
            let bytes = named.as_os_str().len() as u64 + NAME_BYTES;
            self.budget.charge(bytes, || "the names of its files".to_owned())?;
            known.insert(named.to_owned());
        }
        Ok(())
    }

    /// Takes the files recorded by [`Sources::note_named`], sorted.
    pub(super) fn named_files(&self) -> Vec<PathBuf> {
        let mut named: Vec<PathBuf> = self.named.take().into_iter().collect();
        named.sort_unstable();
        named
    }

    /// Finds the file that `place` in the scene references as `named`, relative to the scene.
    ///
    /// # Errors
    /// Returns [`Error::OutsideScene`], [`Error::NotRegularFile`], or the operating system's error.
    pub(super) fn locate(&self, place: &str, named: impl AsRef<Path>) -> Result<Located> {
        let named = named.as_ref();
        let outside = || Error::OutsideScene {
            path: self.scene.to_owned(),
            place: place.to_owned(),
            named: named.to_string_lossy().into_owned(),
        };
        if !self.allow_outside && leaves(named) {
            return Err(outside());
        }
        let beside = self.scene.parent().unwrap_or(Path::new("")).join(named);
        let file = fs::canonicalize(&beside).map_err(IoError::at("read", &beside))?;
        if !self.allow_outside && !file.starts_with(self.folder()?) {
            return Err(outside());
        }
        regular(&file, &self.full(place), fs::metadata(&file))?;
        Ok(Located(file))
    }

    /// Reads the first `max_bytes` bytes of a file that `place` references, or all of it if it is shorter.
    pub(super) fn read_start(&self, file: &Located, place: &str, max_bytes: u64) -> Result<Vec<u8>> {
        self.read_regular(&file.0, &self.full(place), max_bytes)
    }

    /// Reads a file that `place` references, which may have at most `max_bytes` bytes.
    pub(super) fn read_whole(&self, file: &Located, place: &str, max_bytes: u64) -> Result<Vec<u8>> {
        let length = fs::metadata(&file.0).map_err(IoError::at("read", &file.0))?.len();
        if length > max_bytes {
            return Err(
                self.bad(format!("the file of {place} has {length} bytes; at most {max_bytes} are read"))
            );
        }
        self.read_start(file, place, max_bytes)
    }

    /// Describes a part of the scene in an error about a file.
    fn full(&self, place: &str) -> String {
        format!("{place} of {:?}", self.scene.display().to_string())
    }

    /// An [`Error::SceneParse`] for this scene.
    pub(super) fn bad(&self, what: impl Into<String>) -> Error {
        Error::SceneParse { path: self.scene.to_owned(), format: self.format, what: what.into() }
    }

    /// The scene's folder with all links resolved.
    fn folder(&self) -> Result<&Path> {
        if let Some(folder) = self.folder.get() {
            return Ok(folder);
        }
        let parent = self.scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = fs::canonicalize(parent).map_err(IoError::at("read", parent))?;
        Ok(self.folder.get_or_init(|| folder))
    }

    fn read_regular(&self, path: &Path, place: &str, max_bytes: u64) -> Result<Vec<u8>> {
        // Opening a pipe blocks until it has a writer, so the file type is checked first.
        regular(path, place, fs::metadata(path))?;
        let file = File::open(path).map_err(IoError::at("read", path))?;
        let length = regular(path, place, file.metadata())?.min(max_bytes);
        if self.known.borrow_mut().insert(path.to_owned()) {
            self.budget.allow_for(length);
        }
        self.budget.charge(length, || format!("the file {:?}", path.display().to_string()))?;
        let mut bytes = Vec::new();
        let room = usize::try_from(length).map(|n| bytes.try_reserve_exact(n));
        if !matches!(room, Ok(Ok(()))) {
            let source = io::Error::new(ErrorKind::OutOfMemory, "it does not fit in memory");
            return Err(IoError::at("read", path)(source).into());
        }
        file.take(length).read_to_end(&mut bytes).map_err(IoError::at("read", path))?;
        Ok(bytes)
    }
}

/// Reason why a colour-only texture is not read: a clause of a warning.
pub(super) const OUTSIDE: &str = "it is outside the scene's folder, and files outside it are not allowed";

/// Whether a path is not relative or leaves the folder that it starts in.
pub(super) fn leaves(path: &Path) -> bool {
    let mut depth = 0_usize;
    for component in path.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            Component::ParentDir | Component::RootDir | Component::Prefix(_) => return true,
        }
    }
    false
}

/// The length of a regular file; anything else is an error.
fn regular(path: &Path, place: &str, metadata: io::Result<fs::Metadata>) -> Result<u64> {
    let metadata = metadata.map_err(IoError::at("read", path))?;
    if metadata.is_dir() {
        return Err(IoError::at("read", path)(ErrorKind::IsADirectory.into()).into());
    }
    if !metadata.is_file() {
        return Err(Error::NotRegularFile { path: path.to_owned(), place: place.to_owned() });
    }
    Ok(metadata.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn detects_paths_that_leave_a_folder() {
        for inside in ["a.bin", "./a", "a/../b", "a/b/../../c", "..a/b", ""] {
            assert!(!leaves(Path::new(inside)), "{inside}");
        }
        for outside in ["/a", "..", "../a", "a/../../b", "a/../..", "./../a/b"] {
            assert!(leaves(Path::new(outside)), "{outside}");
        }
    }
}
