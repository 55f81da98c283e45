//! Temporary files that killed programs left behind. A running program holds a lock on each of its own
//! temporary files.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use adumbra::IoError;

use crate::folder_of;

const PREFIX: &str = ".adumbra-";
pub(crate) const SUFFIX: &str = ".tmp";
/// Length of the random part of a name.
pub(crate) const RANDOM_BYTES: usize = 6;
/// Names have at most 255 bytes.
const MOST_NAME_BYTES: usize = 200;
/// Returns the prefix of the names of the temporary files for `target`.
pub(crate) fn prefix_of(target: &Path) -> String {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    format!("{PREFIX}{}-", &name[..name.floor_char_boundary(MOST_NAME_BYTES)])
}

/// Removes the abandoned temporary files for `target`.
pub(crate) fn remove_beside(target: &Path) {
    let prefix = prefix_of(target);
    let is_own =
        |name: &str| name.len() == prefix.len() + RANDOM_BYTES + SUFFIX.len() && name.starts_with(&prefix);
    for file in Abandoned::find(&folder_of(target), |name, _| is_own(name)) {
        // An abandoned file that cannot be removed does no harm.
        let _ = file.remove();
    }
}

/// A temporary file of this crate whose program was killed.
#[derive(Debug)]
pub struct Abandoned {
    path: PathBuf,
    bytes: u64,
    /// Locked until the file is removed, so that its name is not reused meanwhile.
    _file: File,
}

impl Abandoned {
    /// Finds the abandoned temporary files of a folder that `is_wanted` accepts by name and age. Where files
    /// cannot be locked, no file is known to be abandoned. In a folder that cannot be read, none is found.
    pub fn find<F: Fn(&str, Duration) -> bool>(
        folder: &Path,
        is_wanted: F,
    ) -> impl Iterator<Item = Self> + use<F> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.filter_map(move |entry| {
            let (name, path) = (entry.file_name().into_string().ok()?, entry.path());
            // Skip links, which lead elsewhere, and pipes, which may block when they are opened.
            let found = entry.metadata().ok().filter(fs::Metadata::is_file)?;
            let is_temporary = name.starts_with(PREFIX) && name.ends_with(SUFFIX);
            let age = SystemTime::now().duration_since(found.modified().ok()?).unwrap_or_default();
            if !is_temporary || !is_wanted(&name, age) {
                return None;
            }
            // File servers lock only writable files.
            let file = File::options().write(true).open(&path).or_else(|_| File::open(&path)).ok()?;
            file.try_lock().ok()?;
            Some(Self { path, bytes: found.len(), _file: file })
        })
    }

    /// Returns the file's length in bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Removes the file.
    ///
    /// # Errors
    /// Returns [`IoError`] if the operating system refuses to.
    pub fn remove(self) -> Result<(), IoError> {
        fs::remove_file(&self.path).map_err(IoError::at("remove", &self.path))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;
    use crate::{StagedFile, replace_file};

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn removes_abandoned_files_and_keeps_files_in_use() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        // Temporary files of other outputs may be in use on another machine, whose locks are invisible here.
        let kept = [".adumbra-file-x-abc123.tmp", ".adumbra-notes", "other.tmp"];
        for name in [kept[0], kept[1], kept[2], ".adumbra-file-abc123.tmp"] {
            fs::write(folder.path().join(name), "left").unwrap();
        }
        let staged = StagedFile::new(&path, |file| file.write_all(b"first").map(|()| 5)).unwrap();
        let held = names(folder.path());
        assert!(held.len() == 4 && kept.iter().all(|name| held.iter().any(|n| n == name)), "{held:?}");
        replace_file(&path, |file| file.write_all(b"second").map(|()| 6)).unwrap();
        assert_eq!(names(folder.path()).len(), 5, "the staged file is in use");
        StagedFile::place([staged]).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"first");
        assert_eq!(names(folder.path()), [kept[0], kept[1], "file", kept[2]]);
    }

    #[test]
    fn accepts_target_names_of_any_length() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a".repeat(255), "ä".repeat(127)] {
            replace_file(&folder.path().join(&name), |file| file.write_all(b"a").map(|()| 1)).unwrap();
        }
        assert_eq!(names(folder.path()).len(), 2);
    }

    #[cfg(unix)]
    #[test]
    fn keeps_links_and_pipes_named_like_temporary_files() {
        let folder = tempfile::tempdir().unwrap();
        let [link, pipe, other] =
            [".adumbra-file-abc123.tmp", ".adumbra-file-abc124.tmp", "other"].map(|n| folder.path().join(n));
        fs::write(&other, "mine").unwrap();
        std::os::unix::fs::symlink(&other, &link).unwrap();
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        replace_file(&folder.path().join("file"), |file| file.write_all(b"a").map(|()| 1)).unwrap();
        assert_eq!(names(folder.path()).len(), 4);
        assert_eq!(fs::read(&other).unwrap(), b"mine");
    }
}
