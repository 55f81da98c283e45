//! Reads files within a limit, and writes files that are either complete or absent: a temporary file next to
//! the target is renamed to it once it is complete. Symbolic links are followed: the link's target is
//! replaced, and the link is kept.

mod abandoned;
mod input;
#[cfg(feature = "watch")]
mod watch;

use std::collections::HashMap;
#[cfg(unix)]
use std::fs::Metadata;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use tempfile::{NamedTempFile, TempPath};

use adumbra::IoError;

pub use abandoned::Abandoned;
pub use input::{TEXT_BYTES, read_text, read_whole};
#[cfg(feature = "watch")]
pub use watch::FileWatch;

/// Largest number of symbolic links that are followed in a chain, as on Linux.
const MAX_LINKS: usize = 40;

/// Calls `write` to fill a temporary file next to `path`, syncs it, and renames it to
/// `path`. Returns what `write` returns.
///
/// # Errors
/// Returns [`IoError`] if the operating system fails. The temporary file is removed and the previous file at
/// `path` is kept.
pub fn replace_file(path: &Path, write: impl FnOnce(&mut File) -> io::Result<u64>) -> Result<u64, IoError> {
    let staged = StagedFile::new(path, write)?;
    let bytes = staged.bytes();
    StagedFile::place([staged])?;
    Ok(bytes)
}

/// Like [`replace_file`], but it replaces a symbolic link at `path` itself, puts the temporary file in
/// `folder`, which must be on the same disk, and does not sync. After a power failure there may be a file at
/// `path` with other contents, so readers must be able to detect that. Remove [`Abandoned`] files from
/// `folder` from time to time.
///
/// # Errors
/// Returns [`IoError`] if the operating system fails. The temporary file is removed and the previous file at
/// `path` is kept.
pub fn replace_unsynced(
    path: &Path,
    folder: &Path,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> Result<(), IoError> {
    let (mut temporary, living) = temporary_in(folder, path, path)?;
    write(temporary.as_file_mut()).map_err(with_hint).map_err(IoError::at("write", path))?;
    let placed = {
        let _placing = lock(&PLACING);
        temporary.persist(path)
    };
    drop(living);
    placed.map(|_| ()).map_err(|e| with_hint(e.error)).map_err(IoError::at("replace", path))
}

/// Temporary files of this process that have not been renamed yet. It is locked while one is created.
static LIVING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
/// Held while files are renamed. It is locked before [`LIVING`].
static PLACING: Mutex<()> = Mutex::new(());

fn lock<T>(mutex: &'static Mutex<T>) -> MutexGuard<'static, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files of this process and ends it by calling `end`. For signal handlers, where no
/// values are dropped. If files are being renamed, all of them are renamed first.
pub fn end_without_temporary_files(end: fn() -> !) -> ! {
    let _placing = lock(&PLACING);
    // Locked until the end, so that no other temporary file is created.
    let living = lock(&LIVING);
    for path in living.iter() {
        // If a file cannot be removed, nothing can be done or reported here.
        let _ = fs::remove_file(path);
    }
    end()
}

/// Keeps the path of a temporary file in [`LIVING`] for as long as the file may exist.
#[derive(Debug)]
struct Living(PathBuf);

impl Drop for Living {
    fn drop(&mut self) {
        lock(&LIVING).retain(|path| *path != self.0);
    }
}

/// A completely written file that has not been renamed to its target yet. The previous file is kept until
/// [`StagedFile::place`]. If this value is dropped, the temporary file is removed.
#[derive(Debug)]
pub struct StagedFile {
    path: PathBuf,
    target: PathBuf,
    temporary: TempPath,
    bytes: u64,
    /// Locked, so that no other program takes the file for an abandoned one.
    _file: File,
    _living: Living,
}

impl StagedFile {
    /// Calls `write` to fill a temporary file next to `path`, and syncs it.
    ///
    /// # Errors
    /// Returns [`IoError`] if the operating system fails. The temporary file is removed and the previous file
    /// at `path` is kept.
    pub fn new(path: &Path, write: impl FnOnce(&mut File) -> io::Result<u64>) -> Result<Self, IoError> {
        let target = target_of(path).map_err(IoError::at("create", path))?;
        abandoned::remove_beside(&target);
        let (temporary, living) = temporary_beside(&target, path)?;
        let (mut file, temporary) = temporary.into_parts();
        let bytes = write(&mut file)
            .and_then(|bytes| file.sync_all().map(|()| bytes))
            .map_err(with_hint)
            .map_err(IoError::at("write", path))?;
        Ok(Self { path: path.to_owned(), target, temporary, bytes, _file: file, _living: living })
    }

    /// Returns the path that the file will have.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns what `write` returned.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Renames the files to their targets, in this order. [`end_without_temporary_files`] waits until all are
    /// renamed.
    ///
    /// # Errors
    /// Returns [`IoError`] if the operating system fails to rename a file. The files before it have been
    /// renamed.
    pub fn place(files: impl IntoIterator<Item = Self>) -> Result<(), IoError> {
        let _placing = lock(&PLACING);
        for Self { path, target, temporary, .. } in files {
            temporary
                .persist(&target)
                .map_err(|e| with_hint(e.error))
                .map_err(IoError::at("replace", path))?;
            announce(&target);
        }
        Ok(())
    }
}

/// Sets the time of a file that has just been renamed to now. Otherwise programs that watch a folder for
/// changes, such as engines that reload assets, may see only that a file with another name has disappeared.
/// If this fails, nothing is lost.
fn announce(target: &Path) {
    let _ = File::options().append(true).open(target).and_then(|file| file.set_modified(SystemTime::now()));
}

/// Checks that a file can be written at `path`, without changing an existing file.
///
/// # Errors
/// Returns the [`IoError`] that [`replace_file`] would return.
pub fn check_output(path: &Path) -> Result<(), IoError> {
    let target = target_of(path).map_err(IoError::at("create", path))?;
    temporary_beside(&target, path).map(|_| ())
}

/// Refuses an existing path that is not a file. The system's links to its own pipes, such as `/dev/stdout`,
/// lead to no path.
fn check_kind(path: &Path) -> io::Result<()> {
    let say = |kind, what: &str| Err(io::Error::new(kind, what));
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => {
            say(ErrorKind::IsADirectory, "it is a folder; give the name of a file in it")
        }
        Ok(found) if !found.is_file() => {
            say(ErrorKind::InvalidInput, "it is a device or a pipe; give the name of a file")
        }
        _ => Ok(()),
    }
}

/// Returns the path at which a file written to `path` will be: `path` itself, or the target of its symbolic
/// links, whether that exists or not.
///
/// # Errors
/// Returns [`io::Error`] if a link cannot be read, or if links form a cycle.
fn target_of(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        match fs::symlink_metadata(&target) {
            Ok(found) if found.is_symlink() => target = folder_of(&target).join(fs::read_link(&target)?),
            _ => return Ok(target),
        }
    }
    let what = format!("too many symbolic links (more than {MAX_LINKS}); give the name of a file");
    Err(io::Error::new(ErrorKind::InvalidInput, what))
}

/// Whether two paths refer to one file, under any spelling and through symbolic or hard links. A file that
/// does not exist yet is identified by its folder and name.
pub fn same_file(a: &Path, b: &Path) -> bool {
    first_same([a, b]).is_some()
}

/// Returns the first two paths, in order, that refer to one file in the sense of [`same_file`].
pub fn first_same<'p>(paths: impl IntoIterator<Item = &'p Path>) -> Option<(&'p Path, &'p Path)> {
    let mut known = HashMap::new();
    for path in paths {
        let Some(key) = Key::of(path) else { continue };
        if let Some(first) = known.insert(key, path) {
            return Some((first, path));
        }
    }
    None
}

/// Identity of a file, which is the same for all of its names.
#[derive(PartialEq, Eq, Hash)]
enum Key {
    Found(Identity),
    /// Canonical path at which the file will be.
    Place(PathBuf),
}

impl Key {
    /// Returns `None` if there cannot be a file at `path`.
    fn of(path: &Path) -> Option<Self> {
        identity(path).map(Key::Found).or_else(|| {
            let target = target_of(path).ok()?;
            Some(Key::Place(folder_of(&target).canonicalize().ok()?.join(target.file_name()?)))
        })
    }
}

#[cfg(unix)]
type Identity = (u64, u64);
#[cfg(not(unix))]
type Identity = PathBuf;

/// Returns the device and inode of a file, which all its hard links share.
#[cfg(unix)]
fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(path).ok().map(|found| (found.dev(), found.ino()))
}

/// Returns the canonical path of a file, which all spellings of its path share. Hard links are not
/// recognized.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<Identity> {
    path.canonicalize().ok()
}

/// Returns the folder that contains a file at `path`.
pub fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Returns the folder in which a file written to `path` will be; symbolic links are followed. It is on the
/// disk of the output, while the system's folder for temporary files may be in memory.
pub fn target_folder(path: &Path) -> PathBuf {
    folder_of(&target_of(path).unwrap_or_else(|_| path.to_owned()))
}

/// Creates an empty temporary file beside `target`, to which `path` leads, with the permissions of the
/// existing file.
fn temporary_beside(target: &Path, path: &Path) -> Result<(NamedTempFile, Living), IoError> {
    let folder = folder_of(target);
    check_kind(path).and_then(|()| check_folder(&folder)).map_err(IoError::at("create", path))?;
    temporary_in(&folder, target, path)
}

/// Creates an empty temporary file in `folder` for `target`, to which `path` leads, with the permissions of
/// an existing file. It is removed when the returned value is dropped.
fn temporary_in(folder: &Path, target: &Path, path: &Path) -> Result<(NamedTempFile, Living), IoError> {
    #[cfg(unix)]
    let permissions =
        fs::symlink_metadata(target).ok().filter(Metadata::is_file).map(|found| found.permissions());
    let prefix = abandoned::prefix_of(target);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(abandoned::SUFFIX).rand_bytes(abandoned::RANDOM_BYTES);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The mode of an ordinary new file, less the umask, because the default of `tempfile` is for secrets.
        // If others may not read the existing file, they may not read the temporary file at any time.
        let mode = permissions.as_ref().map_or(0o666, |p| p.mode() & 0o666 | 0o600);
        builder.permissions(fs::Permissions::from_mode(mode));
    }
    let mut living = lock(&LIVING);
    let locked = || -> io::Result<NamedTempFile> {
        loop {
            let temporary = builder.tempfile_in(folder)?;
            // Where files cannot be locked, no file is known to be abandoned.
            let _ = temporary.as_file().lock();
            // Another program may have removed the file as abandoned before it was locked.
            if temporary.path().exists() {
                return Ok(temporary);
            }
        }
    };
    let temporary = locked().map_err(with_hint).map_err(IoError::at("create", path))?;
    living.push(temporary.path().to_owned());
    drop(living);
    let living = Living(temporary.path().to_owned());
    #[cfg(unix)]
    if let Some(permissions) = permissions {
        // Fails on file systems without permissions, where there are none to keep.
        let _ = temporary.as_file().set_permissions(permissions);
    }
    Ok((temporary, living))
}

/// Detects errors before anything is written, with clearer messages than those of the operating system.
fn check_folder(folder: &Path) -> io::Result<()> {
    let say = |kind, what: String| Err(io::Error::new(kind, what));
    match fs::metadata(folder) {
        Ok(found) if found.is_dir() => {}
        Ok(_) => {
            let what =
                format!("\"{}\" is a file, not a folder; choose another output path", folder.display());
            return say(ErrorKind::NotADirectory, what);
        }
        Err(e) if e.kind() == ErrorKind::NotFound => {
            let what = format!("the folder \"{}\" does not exist; create it first", folder.display());
            return say(ErrorKind::NotFound, what);
        }
        Err(e) if e.kind() == ErrorKind::NotADirectory => {
            let what = format!(
                "a part of \"{}\" is a file, not a folder; choose another output path",
                folder.display()
            );
            return say(ErrorKind::NotADirectory, what);
        }
        Err(e) => return Err(e),
    }
    Ok(())
}

/// Adds a hint on how to fix the error to the message of the operating system. The error kind is kept.
fn with_hint(error: io::Error) -> io::Error {
    let hint = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space, or write to another disk",
        ErrorKind::FileTooLarge => "raise the file size limit, or lower the resolution",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "choose a folder that you may write to, or change its permissions"
        }
        _ => return error,
    };
    io::Error::new(error.kind(), format!("{error}; {hint}"))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use adumbra_testing::EarlierFile;

    use super::*;

    #[test]
    fn replace_file_keeps_previous_file_when_the_disk_fills() {
        let output = EarlierFile::new();
        let result = replace_file(output.path(), |file| {
            file.write_all(b"half")?;
            Err(ErrorKind::StorageFull.into())
        });
        let Err(IoError { action: "write", source, .. }) = result else { panic!("{result:?}") };
        assert_eq!(source.kind(), ErrorKind::StorageFull);
        assert!(source.to_string().contains("free some space"));
        output.assert_kept();
    }

    /// Watchers that pair renames see a change of the file itself only if its time is that of the rename.
    #[test]
    fn placed_file_has_the_time_of_its_rename() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let staged = StagedFile::new(&path, |file| file.write_all(b"new").map(|()| 3)).unwrap();
        std::thread::sleep(std::time::Duration::from_millis(50));
        let before = SystemTime::now() - std::time::Duration::from_millis(20);
        StagedFile::place([staged]).unwrap();
        let modified = fs::metadata(&path).unwrap().modified().unwrap();
        assert!(modified >= before, "{modified:?} {before:?}");
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[test]
    fn same_file_recognizes_any_spelling_of_a_path() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("sub")).unwrap();
        fs::write(at("a"), "a").unwrap();
        fs::write(at("b"), "a").unwrap();
        for spelling in ["a", "./a", "sub/../a", "sub/./../a"] {
            assert!(same_file(&at("a"), &at(spelling)), "{spelling}");
            assert!(!same_file(&at("b"), &at(spelling)), "{spelling}");
        }
        assert!(same_file(&at("new"), &at("sub/../new")) && !same_file(&at("new"), &at("sub/new")));
        assert!(!same_file(&at("missing/a"), &at("missing/a/..")));
    }

    #[cfg(unix)]
    #[test]
    fn same_file_follows_hard_and_symbolic_links() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("a"), "a").unwrap();
        fs::hard_link(at("a"), at("hard")).unwrap();
        symlink("a", at("soft")).unwrap();
        symlink(at("soft"), at("softer")).unwrap();
        symlink("nothing", at("dangling")).unwrap();
        symlink("round", at("round")).unwrap();
        for link in ["hard", "soft", "softer"] {
            assert!(same_file(&at("a"), &at(link)) && same_file(&at(link), &at("a")), "{link}");
        }
        assert!(same_file(&at("dangling"), &at("nothing")) && !same_file(&at("dangling"), &at("a")));
        assert!(!same_file(&at("round"), &at("a")));
    }

    #[cfg(unix)]
    #[test]
    fn replace_file_keeps_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine");
        fs::write(&path, "earlier").unwrap();
        for mode in [0o600, 0o640, 0o664, 0o755] {
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            replace_file(&path, |file| file.write_all(b"new").map(|()| 3)).unwrap();
            assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o7777, mode, "{mode:o}");
        }
    }

    #[test]
    fn staged_files_replace_previous_files_only_when_placed() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a", "b"].map(|name| folder.path().join(name));
        paths.iter().for_each(|path| fs::write(path, "earlier").unwrap());
        let stage =
            || paths.each_ref().map(|p| StagedFile::new(p, |f| f.write_all(b"new").map(|()| 3)).unwrap());
        let known = || lock(&LIVING).iter().filter(|path| path.starts_with(folder.path())).count();
        let all = || paths.each_ref().map(|path| fs::read_to_string(path).unwrap());
        let staged = stage();
        assert_eq!((known(), fs::read_dir(folder.path()).unwrap().count()), (2, 4));
        drop(staged);
        assert_eq!((known(), all()), (0, ["earlier", "earlier"].map(str::to_owned)));
        StagedFile::place(stage()).unwrap();
        assert_eq!((known(), all()), (0, ["new", "new"].map(str::to_owned)));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[cfg(unix)]
    #[test]
    fn replace_file_follows_symbolic_links() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let write = |name: &str| replace_file(&at(name), |file| file.write_all(name.as_bytes()).map(|()| 1));
        fs::create_dir(at("store")).unwrap();
        fs::write(at("store/target"), "earlier").unwrap();
        symlink("store/target", at("near")).unwrap();
        symlink(at("near"), at("link")).unwrap();
        symlink("store/new", at("dangling")).unwrap();
        symlink("missing/new", at("nowhere")).unwrap();
        symlink("there", at("here")).unwrap();
        symlink("here", at("there")).unwrap();
        check_output(&at("link")).unwrap();
        write("link").unwrap();
        write("dangling").unwrap();
        assert_eq!(fs::read(at("store/target")).unwrap(), b"link");
        assert_eq!(fs::read(at("store/new")).unwrap(), b"dangling");
        for link in ["link", "near", "dangling"] {
            assert!(fs::symlink_metadata(at(link)).unwrap().is_symlink(), "{link}");
        }
        let says = |name: &str| write(name).unwrap_err().to_string();
        assert!(says("nowhere").contains("does not exist; create it first"), "{}", says("nowhere"));
        assert!(says("here").contains("too many symbolic links"), "{}", says("here"));
        assert!(check_output(&at("here")).is_err());
        assert_eq!(fs::read_dir(at("store")).unwrap().count(), 2);
    }
}
