//! Objects in a folder: `ab/cdef….object` for the key `abcdef…`, and `new/` for objects that are being written.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use adumbra::IoError;
use adumbra_files::{remove_abandoned, replace_unsynced};

use super::{ObjectKey, Objects};

const EXTENSION: &str = "object";
const NEW: &str = "new";

/// A folder with objects. Bakes on one machine or on many may share it.
#[derive(Clone, Debug)]
pub struct FolderObjects {
    folder: PathBuf,
}

/// What a folder of objects has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FolderContents {
    /// Number of objects.
    pub objects: u64,
    /// Their bytes.
    pub bytes: u64,
}

impl FolderObjects {
    /// Uses a folder, and creates it if it is not there.
    ///
    /// # Errors
    /// Returns [`IoError`] if the folder cannot be created.
    pub fn create(folder: impl Into<PathBuf>) -> Result<Self, IoError> {
        let folder = folder.into();
        let new = folder.join(NEW);
        fs::create_dir_all(&new).map_err(IoError::at("create", &folder))?;
        remove_abandoned(&new);
        Ok(Self { folder })
    }

    /// Uses a folder that is there.
    ///
    /// # Errors
    /// Returns [`IoError`] if there is no folder.
    pub fn open(folder: impl Into<PathBuf>) -> Result<Self, IoError> {
        let folder = folder.into();
        fs::read_dir(&folder).map_err(IoError::at("read", &folder))?;
        remove_abandoned(&folder.join(NEW));
        Ok(Self { folder })
    }

    /// Counts the objects.
    ///
    /// # Errors
    /// Returns [`IoError`] if the folder cannot be read.
    pub fn contents(&self) -> Result<FolderContents, IoError> {
        let mut contents = FolderContents::default();
        for Found { bytes, .. } in self.list()? {
            contents.objects += 1;
            contents.bytes += bytes;
        }
        Ok(contents)
    }

    /// Removes objects until the others have at most `most_bytes`; those that were used longest ago go first. Returns what
    /// was removed.
    ///
    /// # Errors
    /// Returns [`IoError`] if the folder cannot be read, or an object cannot be removed.
    pub fn prune(&self, most_bytes: u64) -> Result<FolderContents, IoError> {
        let mut found = self.list()?;
        found.sort_by(|a, b| (a.used, &a.path).cmp(&(b.used, &b.path)));
        let mut left: u64 = found.iter().map(|object| object.bytes).sum();
        let mut removed = FolderContents::default();
        for Found { path, bytes, .. } in found {
            if left <= most_bytes {
                break;
            }
            match fs::remove_file(&path) {
                // Another program was faster.
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                result => result.map_err(IoError::at("remove", &path))?,
            }
            left -= bytes;
            removed.objects += 1;
            removed.bytes += bytes;
        }
        Ok(removed)
    }

    fn list(&self) -> Result<Vec<Found>, IoError> {
        let mut list = Vec::new();
        for folder in entries(&self.folder)? {
            if !folder.is_dir() {
                continue;
            }
            for path in entries(&folder)? {
                let is_object = path.extension() == Some(OsStr::new(EXTENSION));
                // One that is gone by now is none.
                if let (true, Ok(found)) = (is_object, fs::metadata(&path)) {
                    let used = found.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                    list.push(Found { path, bytes: found.len(), used });
                }
            }
        }
        Ok(list)
    }

    fn path(&self, key: &ObjectKey) -> PathBuf {
        let name = key.to_string();
        let (folder, rest) = name.split_at(2);
        self.folder.join(folder).join(rest).with_extension(EXTENSION)
    }
}

/// An object in a folder.
struct Found {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, IoError> {
    let paths = fs::read_dir(folder).and_then(|all| all.map(|entry| entry.map(|e| e.path())).collect());
    paths.map_err(IoError::at("read", folder))
}

impl Objects for FolderObjects {
    fn get(&self, key: &ObjectKey) -> Result<Option<Vec<u8>>, IoError> {
        let path = self.path(key);
        match fs::read(&path) {
            Ok(bytes) => {
                // The time of use, for pruning. A folder that cannot be written has none.
                let _ =
                    File::options().append(true).open(&path).and_then(|f| f.set_modified(SystemTime::now()));
                Ok(Some(bytes))
            }
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(IoError::at("read", path)(error)),
        }
    }

    fn put(&self, key: &ObjectKey, bytes: &[u8]) -> Result<(), IoError> {
        let path = self.path(key);
        let folder = path.parent().unwrap_or(&self.folder);
        fs::create_dir_all(folder).map_err(IoError::at("create", folder))?;
        // Not synced: what a power failure damages does not have its checksum, and is made again.
        replace_unsynced(&path, &self.folder.join(NEW), |file| file.write_all(bytes))
    }
}
