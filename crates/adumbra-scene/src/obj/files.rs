//! The files that OBJ and MTL files name. A name is a string of bytes. It may be in quotes, contain spaces or
//! backslashes, and differ in case from the file, because the scene may have been written on Windows.

use std::cell::RefCell;
use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::rc::Rc;

use hashbrown::HashMap;

use crate::obj::text::{Name, shown, trim, unquoted, words};
use crate::sources::{Located, Sources, leaves};
use crate::{Error, Result};

/// Memory per file of a folder that is searched without regard to case, in addition to its name, bytes.
const ENTRY_BYTES: u64 = 100;

/// The files of a folder by their names in lower case; `None` where several names differ only in case.
type Listing = HashMap<String, Option<OsString>>;

/// Finds the files that a scene names.
pub(super) struct Files<'a> {
    pub(super) sources: &'a Sources<'a>,
    /// The scene's folder with all links resolved; `None` if it cannot be read.
    folder: Option<PathBuf>,
    listings: RefCell<HashMap<PathBuf, Rc<Listing>>>,
}

impl<'a> Files<'a> {
    pub(super) fn new(sources: &'a Sources<'a>) -> Self {
        let parent = sources.scene.parent().filter(|p| !p.as_os_str().is_empty());
        let folder = fs::canonicalize(parent.unwrap_or(Path::new("."))).ok();
        Self { sources, folder, listings: RefCell::default() }
    }

    /// Records every string of a statement that may name a file: all of it, because a name may contain
    /// spaces, and each of its words, because there may be several names, or options before the name.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`] if the names do not fit the memory budget.
    pub(super) fn note(&self, statement: &Name) -> Result<()> {
        let all = both(statement).into_iter().chain(words(&statement.short));
        all.map(unquoted).try_for_each(|name| self.note_file(name))
    }

    /// Records a name.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`] if it does not fit the memory budget.
    pub(super) fn note_file(&self, name: &[u8]) -> Result<()> {
        self.sources.note_named(path_of(name))
    }

    /// Returns the file of the first of these names that matches one. A name matches a file exactly, or when
    /// read as Latin-1, or in another case if it then matches only one file.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`], or the error of the first name.
    pub(super) fn locate(&self, place: &str, names: &[&[u8]]) -> Result<Located> {
        let mut first_error = None;
        for name in names.iter().map(|name| path_of(name)) {
            match self.locate_path(place, &name) {
                Ok(located) => return Ok(located),
                Err(e @ Error::SceneMemory { .. }) => return Err(e),
                Err(e) => {
                    first_error.get_or_insert(e);
                }
            }
        }
        Err(first_error.unwrap_or_else(|| self.sources.bad(format!("{place} names no file"))))
    }

    fn locate_path(&self, place: &str, name: &Path) -> Result<Located> {
        let error = match self.sources.locate(place, name) {
            Err(e @ Error::Io(_)) => e,
            done => return done,
        };
        let mut other = Vec::new();
        if name.to_str().is_none() {
            other.push(PathBuf::from(shown(name.as_os_str().as_encoded_bytes()).as_ref()));
        }
        for name in std::iter::once(name.to_owned()).chain(other) {
            if let Some(real) = self.in_its_case(&name)?
                && let Ok(located) = self.sources.locate(place, &real)
            {
                self.sources.note_named(real)?;
                return Ok(located);
            }
        }
        Err(error)
    }

    /// The path with each component in the case that the file system has, if only one file matches.
    fn in_its_case(&self, name: &Path) -> Result<Option<PathBuf>> {
        let Some(folder) = self.folder.as_ref().filter(|_| !leaves(name)) else { return Ok(None) };
        let (mut at, mut real) = (folder.clone(), PathBuf::new());
        for component in name.components() {
            match component {
                Component::CurDir => {}
                Component::ParentDir => {
                    at.pop();
                    real.push(component);
                }
                Component::Normal(part) => {
                    let part = match at.join(part).exists() {
                        true => part.to_owned(),
                        false => {
                            let listing = self.listing(&at, folder)?;
                            match listing.get(&part.to_string_lossy().to_lowercase()) {
                                Some(Some(part)) => part.clone(),
                                _ => return Ok(None),
                            }
                        }
                    };
                    at.push(&part);
                    real.push(part);
                }
                Component::RootDir | Component::Prefix(_) => return Ok(None),
            }
        }
        Ok(Some(real))
    }

    /// The files in a folder; empty for a folder outside the scene's folder.
    fn listing(&self, at: &Path, folder: &Path) -> Result<Rc<Listing>> {
        if let Some(known) = self.listings.borrow().get(at) {
            return Ok(known.clone());
        }
        let mut listing = Listing::new();
        let inside = fs::canonicalize(at).is_ok_and(|at| at.starts_with(folder));
        let entries = if inside { fs::read_dir(at).ok() } else { None };
        for entry in entries.into_iter().flatten().filter_map(std::result::Result::ok) {
            let name = entry.file_name();
            let bytes = 2 * name.len() as u64 + ENTRY_BYTES;
            self.sources.budget.charge(bytes, || "the names of the files beside it".to_owned())?;
            let lower = name.to_string_lossy().to_lowercase();
            listing.entry(lower).and_modify(|several| *several = None).or_insert(Some(name));
        }
        let listing = Rc::new(listing);
        self.listings.borrow_mut().insert(at.to_owned(), listing.clone());
        Ok(listing)
    }
}

/// The names that a statement with a single name may mean: without its comment, then with it.
pub(super) fn both(name: &Name) -> Vec<&[u8]> {
    let mut both = vec![name.short.as_slice()];
    if name.long != name.short {
        both.push(&name.long);
    }
    both
}

/// Splits a statement that may hold several names. A name is in quotes, or extends to a word with this
/// ending.
pub(super) fn several<'n>(text: &'n [u8], ending: &str) -> Vec<&'n [u8]> {
    let mut names = Vec::new();
    let mut text = trim(text);
    while !text.is_empty() {
        let end = match text {
            [b'"', inside @ ..] => inside.iter().position(|&b| b == b'"').map(|at| at + 2),
            _ => end_of_name(text, ending),
        };
        let (name, rest) = text.split_at(end.unwrap_or(text.len()));
        names.push(unquoted(trim(name)));
        text = trim(rest);
    }
    names
}

/// The length of the text from its start to the end of the first word with this ending.
fn end_of_name(text: &[u8], ending: &str) -> Option<usize> {
    let mut end = 0;
    for word in words(text) {
        // Words are slices of the text, in order.
        let gap = text.get(end..)?.windows(word.len()).position(|w| w == word)?;
        end += gap + word.len();
        let last = word.len().checked_sub(ending.len()).and_then(|at| word.get(at..));
        if last.is_some_and(|last| last.eq_ignore_ascii_case(ending.as_bytes())) {
            return Some(end);
        }
    }
    None
}

/// The path that a name in a file stands for.
fn path_of(name: &[u8]) -> PathBuf {
    let slashed: Vec<u8> = name.iter().map(|&b| if b == b'\\' { b'/' } else { b }).collect();
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStringExt;
        PathBuf::from(OsString::from_vec(slashed))
    }
    #[cfg(not(unix))]
    {
        PathBuf::from(shown(&slashed).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_a_statement_into_several_names() {
        let is = |text: &str, expected: &[&str]| {
            let names: Vec<_> = several(text.as_bytes(), ".mtl").into_iter().map(shown).collect();
            assert_eq!(names, expected, "{text}");
        };
        is("a.mtl", &["a.mtl"]);
        is("a.mtl b.MTL", &["a.mtl", "b.MTL"]);
        is("my mat.mtl  other.mtl", &["my mat.mtl", "other.mtl"]);
        is("\"my mat.mtl\" \"b\" c d", &["my mat.mtl", "b", "c d"]);
        is("\"open", &["\"open"]);
        is(" ", &[]);
    }
}
