//! The files of a scene: the scene itself, and the buffers, images and material libraries that it names.
//!
//! A scene may come from anyone. What it names must lie in its own folder unless the caller allows more, only regular files are read,
//! and no more of them than they are said to hold.

use std::cell::{OnceCell, RefCell};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};

use hashbrown::HashSet;

use super::LoadOptions;
use super::budget::Budget;
use crate::error::{Error, Result};

/// Bytes that a material library may have.
pub(super) const MAX_LIBRARY_BYTES: u64 = 256 << 20;
/// Bytes that an image file may have.
pub(super) const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// Bytes that remembering a file takes beside its name.
const NAME_BYTES: u64 = 80;

/// Where a scene's bytes come from, and how much of them may be held.
pub(super) struct Sources<'a> {
    /// The scene file.
    pub(super) scene: &'a Path,
    /// What the load holds.
    pub(super) budget: Budget<'a>,
    /// "glTF", "OBJ" or "PLY".
    format: &'static str,
    allow_outside: bool,
    folder: OnceCell<PathBuf>,
    known: RefCell<HashSet<PathBuf>>,
    named: RefCell<HashSet<PathBuf>>,
}

/// A regular file that a scene may read, with all links followed.
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

    /// The whole scene file; an empty one is refused.
    pub(super) fn read_scene(&self) -> Result<Vec<u8>> {
        let bytes = self.read_regular(self.scene, "the scene", u64::MAX)?;
        if bytes.is_empty() {
            return Err(self.bad("the file is empty"));
        }
        Ok(bytes)
    }

    /// Remembers a file that the scene names, whether it is read or not, for [`LoadNotes::named_files`](super::LoadNotes::named_files).
    ///
    /// # Errors
    /// [`Error::SceneMemory`].
    pub(super) fn note_named(&self, named: &str) -> Result<()> {
        let mut known = self.named.borrow_mut();
        if !known.contains(Path::new(named)) {
            self.budget.charge(named.len() as u64 + NAME_BYTES, || "the names of its files".to_owned())?;
            known.insert(PathBuf::from(named));
        }
        Ok(())
    }

    /// What [`Sources::note_named`] has remembered, in order.
    pub(super) fn named_files(&self) -> Vec<PathBuf> {
        let mut named: Vec<PathBuf> = self.named.take().into_iter().collect();
        named.sort_unstable();
        named
    }

    /// Finds the file that `place` in the scene names, relative to the scene.
    ///
    /// # Errors
    /// [`Error::OutsideScene`], [`Error::NotRegularFile`], or what the system says.
    pub(super) fn locate(&self, place: &str, named: &str) -> Result<Located> {
        let outside = || Error::OutsideScene {
            path: self.scene.to_owned(),
            place: place.to_owned(),
            named: named.to_owned(),
        };
        if !self.allow_outside && leaves(Path::new(named)) {
            return Err(outside());
        }
        let beside = self.scene.parent().unwrap_or(Path::new("")).join(named);
        let file = fs::canonicalize(&beside).map_err(Error::io("read", &beside))?;
        if !self.allow_outside && !file.starts_with(self.folder()?) {
            return Err(outside());
        }
        regular(&file, &self.full(place), fs::metadata(&file))?;
        Ok(Located(file))
    }

    /// The first `max_bytes` bytes of a file that `place` names, or all of it.
    pub(super) fn read_start(&self, file: &Located, place: &str, max_bytes: u64) -> Result<Vec<u8>> {
        self.read_regular(&file.0, &self.full(place), max_bytes)
    }

    /// A file of at most `max_bytes` bytes that `place` names.
    pub(super) fn read_whole(&self, file: &Located, place: &str, max_bytes: u64) -> Result<Vec<u8>> {
        let length = fs::metadata(&file.0).map_err(Error::io("read", &file.0))?.len();
        if length > max_bytes {
            return Err(
                self.bad(format!("the file of {place} has {length} bytes; at most {max_bytes} are read"))
            );
        }
        self.read_start(file, place, max_bytes)
    }

    /// Names a part of the scene in an error about a file.
    fn full(&self, place: &str) -> String {
        format!("{place} of {:?}", self.scene.display().to_string())
    }

    /// [`Error::SceneParse`] for this scene.
    pub(super) fn bad(&self, what: impl Into<String>) -> Error {
        Error::SceneParse { path: self.scene.to_owned(), format: self.format, what: what.into() }
    }

    /// The scene's folder with all links followed.
    fn folder(&self) -> Result<&Path> {
        if let Some(folder) = self.folder.get() {
            return Ok(folder);
        }
        let parent = self.scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = fs::canonicalize(parent).map_err(Error::io("read", parent))?;
        Ok(self.folder.get_or_init(|| folder))
    }

    fn read_regular(&self, path: &Path, place: &str, max_bytes: u64) -> Result<Vec<u8>> {
        // Opening a pipe waits for whoever writes to it, so its kind is asked first.
        regular(path, place, fs::metadata(path))?;
        let file = File::open(path).map_err(Error::io("read", path))?;
        let length = regular(path, place, file.metadata())?.min(max_bytes);
        if self.known.borrow_mut().insert(path.to_owned()) {
            self.budget.allow_for(length);
        }
        self.budget.charge(length, || format!("the file {:?}", path.display().to_string()))?;
        let mut bytes = Vec::new();
        let room = usize::try_from(length).map(|n| bytes.try_reserve_exact(n));
        if !matches!(room, Ok(Ok(()))) {
            return Err(Error::io("read", path)(io::Error::new(
                ErrorKind::OutOfMemory,
                "it does not fit the memory",
            )));
        }
        file.take(length).read_to_end(&mut bytes).map_err(Error::io("read", path))?;
        Ok(bytes)
    }
}

/// Why a texture that only colours is not read: a clause of a warning.
pub(super) const OUTSIDE: &str = "it lies outside the scene's folder; --allow-outside reads it";

/// Whether a relative path leaves the folder that it starts in, or is not relative.
fn leaves(path: &Path) -> bool {
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

/// The length of a regular file; anything else is refused.
fn regular(path: &Path, place: &str, metadata: io::Result<fs::Metadata>) -> Result<u64> {
    let metadata = metadata.map_err(Error::io("read", path))?;
    if metadata.is_dir() {
        return Err(Error::io("read", path)(ErrorKind::IsADirectory.into()));
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
    fn paths_that_leave_a_folder() {
        for inside in ["a.bin", "./a", "a/../b", "a/b/../../c", "..a/b", ""] {
            assert!(!leaves(Path::new(inside)), "{inside}");
        }
        for outside in ["/a", "..", "../a", "a/../../b", "a/../..", "./../a/b"] {
            assert!(leaves(Path::new(outside)), "{outside}");
        }
    }
}
