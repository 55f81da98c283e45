//! An earlier output, which a test replaces or fails to replace.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

const CONTENTS: &[u8] = b"earlier";

/// An earlier output: the only file of a temporary folder.
pub struct EarlierFile {
    folder: TempDir,
    path: PathBuf,
}

impl Default for EarlierFile {
    fn default() -> Self {
        Self::new()
    }
}

impl EarlierFile {
    /// Writes the file.
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.adumbra");
        fs::write(&path, CONTENTS).unwrap();
        Self { folder, path }
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Checks that the file was left as it was.
    ///
    /// # Panics
    /// Panics if the file was changed, or if another file is in the folder.
    pub fn assert_kept(&self) {
        self.assert_replaced_by(CONTENTS);
    }

    /// Checks that the file now has these bytes.
    ///
    /// # Panics
    /// Panics if the file has other bytes, or if another file is in the folder.
    pub fn assert_replaced_by(&self, bytes: &[u8]) {
        assert_eq!(fs::read(&self.path).unwrap(), bytes);
        assert_eq!(fs::read_dir(&self.folder).unwrap().count(), 1, "a temporary file is left");
    }
}
