//! A cache in a folder: `ab/cdef….entry` for the key `abcdef…`, and `new/` for entries that are being
//! written.

use std::fs::{self, File, Metadata};
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use adumbra::IoError;
use adumbra_files::{Abandoned, replace_unsynced};

use super::entry::ENTRY_MAGIC;
use super::{BakeCache, CacheKey, Fetched};

const EXTENSION: &str = "entry";
const NEW: &str = "new";
/// Entries are written in less than a second. Other machines may share the folder, and their locks may not be
/// seen here.
const ABANDONED_AFTER: Duration = Duration::from_hours(24);

/// A cache in a folder, which bakes on one machine or many may share. Other files in the folder are left
/// alone, and symbolic links are not followed.
#[derive(Clone, Debug)]
pub struct DiskCache {
    folder: PathBuf,
}

/// What counting found in a cache, or pruning removed from it.
#[derive(Debug, Default)]
pub struct CacheReport {
    /// Number of entries.
    pub entries: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Number of temporary files that programs left more than a day ago because they were killed.
    pub abandoned: u64,
    /// Their bytes.
    pub abandoned_bytes: u64,
    /// The failures to read or remove files.
    pub failures: Vec<IoError>,
}

impl DiskCache {
    /// Uses a folder, and creates it if it does not exist. Removes temporary files that programs left more
    /// than a day ago.
    ///
    /// # Errors
    /// Returns [`IoError`] if the folder cannot be created.
    pub fn create(folder: impl Into<PathBuf>) -> Result<Self, IoError> {
        let folder = folder.into();
        fs::create_dir_all(&folder).map_err(IoError::at("create", &folder))?;
        let cache = Self { folder };
        cache.abandoned().for_each(|file| _ = file.remove());
        Ok(cache)
    }

    /// Uses an existing folder.
    ///
    /// # Errors
    /// Returns [`IoError`] if there is no folder.
    pub fn open(folder: impl Into<PathBuf>) -> Result<Self, IoError> {
        let folder = folder.into();
        fs::read_dir(&folder).map_err(IoError::at("read", &folder))?;
        Ok(Self { folder })
    }

    /// Counts the entries.
    ///
    /// # Errors
    /// Returns [`IoError`] if the folder cannot be read.
    pub fn contents(&self) -> Result<CacheReport, IoError> {
        let (entries, failures) = self.list()?;
        let mut found = CacheReport { failures, ..CacheReport::default() };
        entries.iter().for_each(|entry| found.add_entry(entry.bytes));
        self.abandoned().for_each(|file| found.add_abandoned(file.bytes()));
        Ok(found)
    }

    /// Removes temporary files that were left more than a day ago, then the least recently used entries until
    /// the others have at most `most_bytes`. Returns what was removed. Files that cannot be removed stay, and
    /// are listed as failures.
    ///
    /// # Errors
    /// Returns [`IoError`] if the folder cannot be read.
    pub fn prune(&self, most_bytes: u64) -> Result<CacheReport, IoError> {
        let (mut found, failures) = self.list()?;
        let mut removed = CacheReport { failures, ..CacheReport::default() };
        for file in self.abandoned() {
            let bytes = file.bytes();
            match file.remove() {
                Ok(()) => removed.add_abandoned(bytes),
                Err(error) => removed.failures.push(error),
            }
        }
        found.sort_by(|a, b| (a.used, &a.path).cmp(&(b.used, &b.path)));
        let mut left: u64 = found.iter().map(|entry| entry.bytes).sum();
        for Found { path, bytes, .. } in found {
            if left <= most_bytes {
                break;
            }
            match fs::remove_file(&path) {
                // Another program has removed the entry.
                Err(error) if error.kind() == ErrorKind::NotFound => left -= bytes,
                Err(error) => removed.failures.push(IoError::at("remove", path)(error)),
                Ok(()) => {
                    left -= bytes;
                    removed.add_entry(bytes);
                }
            }
        }
        Ok(removed)
    }

    fn abandoned(&self) -> impl Iterator<Item = Abandoned> + use<> {
        let new = self.folder.join(NEW);
        let all = is_folder(&new).then(|| Abandoned::find(&new, |_, age| age > ABANDONED_AFTER));
        all.into_iter().flatten()
    }

    /// Returns the entries, and the errors of folders and files that could not be read.
    fn list(&self) -> Result<(Vec<Found>, Vec<IoError>), IoError> {
        let (mut list, mut failures) = (Vec::new(), Vec::new());
        for (first, folder) in entries(&self.folder)? {
            if !is_name(&first, 2) || !is_folder(&folder) {
                continue;
            }
            let within = entries(&folder).unwrap_or_else(|error| {
                failures.push(error);
                Vec::new()
            });
            for (name, path) in within {
                let rest = name.strip_suffix(EXTENSION).and_then(|name| name.strip_suffix('.'));
                if !rest.is_some_and(|rest| is_name(rest, 62)) {
                    continue;
                }
                match metadata_of_entry(&path) {
                    Ok(Some(found)) => {
                        let used = found.modified().unwrap_or(SystemTime::UNIX_EPOCH);
                        list.push(Found { path, bytes: found.len(), used });
                    }
                    Ok(None) => {}
                    // Skip an entry that another process has removed.
                    Err(error) if error.kind() == ErrorKind::NotFound => {}
                    Err(error) => failures.push(IoError::at("read", path)(error)),
                }
            }
        }
        Ok((list, failures))
    }

    fn path(&self, key: &CacheKey) -> PathBuf {
        let name = key.to_string();
        let (folder, rest) = name.split_at(2);
        self.folder.join(folder).join(rest).with_extension(EXTENSION)
    }
}

impl CacheReport {
    fn add_entry(&mut self, bytes: u64) {
        self.entries += 1;
        self.bytes += bytes;
    }

    fn add_abandoned(&mut self, bytes: u64) {
        self.abandoned += 1;
        self.abandoned_bytes += bytes;
    }
}

/// An entry in a folder.
struct Found {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
}

/// Lists the names and paths in a folder. Skips names that are not UTF-8, because no entry has such a name.
fn entries(folder: &Path) -> Result<Vec<(String, PathBuf)>, IoError> {
    let named = |entry: fs::DirEntry| Some((entry.file_name().into_string().ok()?, entry.path()));
    let all = fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    Ok(all.map_err(IoError::at("read", folder))?.into_iter().filter_map(named).collect())
}

/// Whether the path is a folder, not a link to one.
fn is_folder(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_dir())
}

/// Whether a name consists of exactly this many lower-case hexadecimal digits.
fn is_name(name: &str, digits: usize) -> bool {
    name.len() == digits && name.bytes().all(|c| matches!(c, b'0'..=b'9' | b'a'..=b'f'))
}

/// Returns the metadata of the entry at a path, or `None` if the file is not an entry. An entry that a power
/// failure has truncated or filled with zeros counts.
fn metadata_of_entry(path: &Path) -> std::io::Result<Option<Metadata>> {
    let found = fs::symlink_metadata(path)?;
    if !found.is_file() {
        return Ok(None);
    }
    let mut magic = Vec::new();
    File::open(path)?.take(ENTRY_MAGIC.len() as u64).read_to_end(&mut magic)?;
    let is_entry = ENTRY_MAGIC.starts_with(&magic) || magic.iter().all(|&byte| byte == 0);
    Ok(is_entry.then_some(found))
}

impl BakeCache for DiskCache {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        let path = self.path(key);
        let read = || -> std::io::Result<Fetched> {
            let found = fs::symlink_metadata(&path)?;
            if !found.is_file() || !path.parent().is_some_and(is_folder) {
                return Ok(Fetched::Nothing);
            }
            if found.len() > most_bytes {
                return Ok(Fetched::TooLong(found.len()));
            }
            let mut bytes = Vec::with_capacity(found.len() as usize);
            // The file may grow while it is read.
            File::open(&path)?.take(most_bytes).read_to_end(&mut bytes)?;
            // Records the time of use for pruning. Ignores the failure in a read-only folder.
            let _ = File::options().append(true).open(&path).and_then(|f| f.set_modified(SystemTime::now()));
            Ok(Fetched::Whole(bytes))
        };
        match read() {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Fetched::Nothing),
            found => found.map_err(IoError::at("read", &path)),
        }
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        let path = self.path(key);
        let new = self.folder.join(NEW);
        for folder in [path.parent().unwrap_or(&self.folder), &new] {
            fs::create_dir_all(folder).map_err(IoError::at("create", folder))?;
            if !is_folder(folder) {
                let linked = std::io::Error::other("it is a link, and a cache follows none");
                return Err(IoError::at("write to", folder)(linked));
            }
        }
        // Not synced: an entry that a power failure damages fails its checksum, and its part is baked again.
        replace_unsynced(&path, &new, |file| file.write_all(bytes))
    }
}
