//! Files that are there whole or not at all: a temporary file beside the target takes its name once it is complete. A symbolic link is
//! followed: the file that it leads to is replaced, and the link stays.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{NamedTempFile, TempPath};

use crate::error::{Error, Result};

/// Most symbolic links that are followed from one to the next, as Linux does it.
const MAX_LINKS: usize = 40;

/// Has `write` fill a temporary file beside `path`, syncs it, and gives it that name; returns what `write` returns.
///
/// # Errors
/// [`Error::Io`] where the system refuses; the temporary file is removed and what was at `path` stays as it was.
pub fn replace_file(path: &Path, write: impl FnOnce(&mut File) -> io::Result<u64>) -> Result<u64> {
    let staged = StagedFile::new(path, write)?;
    let bytes = staged.bytes();
    StagedFile::place([staged])?;
    Ok(bytes)
}

/// Temporary files of this process that have not got their names yet. It is locked while one is made.
static LIVING: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
/// Held while files get their names; locked before [`LIVING`].
static PLACING: Mutex<()> = Mutex::new(());

fn lock<T>(mutex: &'static Mutex<T>) -> MutexGuard<'static, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files of this process and ends it, for handlers of signals: there no value is dropped. Files that are getting
/// their names get them all first.
pub fn end_without_temporary_files(end: fn() -> !) -> ! {
    let _placing = lock(&PLACING);
    // Locked until the end: no other is made.
    let living = lock(&LIVING);
    for path in living.iter() {
        // Nothing can be said or done about one that stays.
        let _ = fs::remove_file(path);
    }
    end()
}

/// Keeps a temporary file in [`LIVING`] for as long as it may exist.
#[derive(Debug)]
struct Living(PathBuf);

impl Drop for Living {
    fn drop(&mut self) {
        lock(&LIVING).retain(|path| *path != self.0);
    }
}

/// A file that is written whole but has not got its name yet: until [`StagedFile::place`] what was there stays, and where this is dropped
/// nothing is left of it.
#[derive(Debug)]
pub struct StagedFile {
    path: PathBuf,
    target: PathBuf,
    temporary: TempPath,
    bytes: u64,
    _living: Living,
}

impl StagedFile {
    /// Has `write` fill a temporary file beside `path`, and syncs it.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses; the temporary file is removed and what was at `path` stays as it was.
    pub fn new(path: &Path, write: impl FnOnce(&mut File) -> io::Result<u64>) -> Result<Self> {
        let target = target_of(path).map_err(Error::io("create", path))?;
        let (temporary, living) = temporary_beside(path, &target)?;
        let (mut file, temporary) = temporary.into_parts();
        let bytes = write(&mut file)
            .and_then(|bytes| file.sync_all().map(|()| bytes))
            .map_err(with_mend)
            .map_err(Error::io("write", path))?;
        Ok(Self { path: path.to_owned(), target, temporary, bytes, _living: living })
    }

    /// The name that it will get.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What `write` returned.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Gives the files their names, in this order. An interrupt waits until all have theirs.
    ///
    /// # Errors
    /// [`Error::Io`] where the system refuses one; those before it have got theirs.
    pub fn place(files: impl IntoIterator<Item = Self>) -> Result<()> {
        let _placing = lock(&PLACING);
        for Self { path, target, temporary, .. } in files {
            temporary.persist(&target).map_err(|e| with_mend(e.error)).map_err(Error::io("replace", path))?;
        }
        Ok(())
    }
}

/// Whether a file could be written at `path`; touches nothing that is there.
///
/// # Errors
/// [`Error::Io`] as [`replace_file`] would give it.
pub fn check_output(path: &Path) -> Result<()> {
    let target = target_of(path).map_err(Error::io("create", path))?;
    temporary_beside(path, &target).map(|_| ())
}

/// Where a file that is written at `path` will lie: `path` itself, or what its symbolic links lead to, whether that exists or not.
///
/// # Errors
/// [`io::Error`] where a link cannot be read, or links lead to each other.
pub fn target_of(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        match fs::symlink_metadata(&target) {
            Ok(found) if found.is_symlink() => target = folder_of(&target).join(fs::read_link(&target)?),
            _ => return Ok(target),
        }
    }
    let what = format!("its symbolic links do not end after {MAX_LINKS}; give the name of a file");
    Err(io::Error::new(ErrorKind::InvalidInput, what))
}

/// Whether two paths are one file, under any spelling and by symbolic or hard links. A file that does not exist yet is known by its folder
/// and its name.
pub fn same_file(a: &Path, b: &Path) -> bool {
    first_same([a, b]).is_some()
}

/// The first two paths that are [`same_file`], in their order.
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

/// What all names of a file have in common.
#[derive(PartialEq, Eq, Hash)]
enum Key {
    Found(Identity),
    /// Where it will be.
    Place(PathBuf),
}

impl Key {
    /// None where there cannot be a file.
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

/// What hard links to a file have in common.
#[cfg(unix)]
fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(path).ok().map(|found| (found.dev(), found.ino()))
}

/// What spellings of a file's path have in common; its hard links are not known.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<Identity> {
    path.canonicalize().ok()
}

/// The folder that a file at `path` lies in.
pub fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// An empty temporary file in the folder of `target`, to which `path` leads, with the permissions of what is there; it goes away with the
/// value.
fn temporary_beside(path: &Path, target: &Path) -> Result<(NamedTempFile, Living)> {
    let folder = folder_of(target);
    check_target(target, &folder).map_err(Error::io("create", path))?;
    #[cfg(unix)]
    let permissions = fs::metadata(target).ok().map(|found| found.permissions());
    let mut builder = tempfile::Builder::new();
    builder.prefix(".adumbra-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As an ordinary new file, less the umask; the default is for secrets. What others may not read stays so from the start.
        let mode = permissions.as_ref().map_or(0o666, |p| p.mode() & 0o666 | 0o600);
        builder.permissions(fs::Permissions::from_mode(mode));
    }
    let mut living = lock(&LIVING);
    let temporary = builder.tempfile_in(&folder).map_err(with_mend).map_err(Error::io("create", path))?;
    living.push(temporary.path().to_owned());
    drop(living);
    let living = Living(temporary.path().to_owned());
    #[cfg(unix)]
    if let Some(permissions) = permissions {
        // A file system without permissions has none to keep.
        let _ = temporary.as_file().set_permissions(permissions);
    }
    Ok((temporary, living))
}

/// Finds, before anything is written, what the system would say less clearly.
fn check_target(path: &Path, folder: &Path) -> io::Result<()> {
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
    match fs::metadata(path) {
        Ok(found) if found.is_dir() => {
            say(ErrorKind::IsADirectory, "it is a folder; give the name of a file in it".to_owned())
        }
        Ok(found) if !found.is_file() => {
            say(ErrorKind::InvalidInput, "it is a device or a pipe; give the name of a file".to_owned())
        }
        _ => Ok(()),
    }
}

/// Adds to what the system says what can be done about it; the kind stays.
fn with_mend(error: io::Error) -> io::Error {
    let mend = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "free some space, or write to another disk",
        ErrorKind::FileTooLarge => "raise the limit on file sizes, or lower the resolution",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "choose a folder that you may write to, or change its permissions"
        }
        _ => return error,
    };
    io::Error::new(error.kind(), format!("{error}; {mend}"))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn replace_file_leaves_the_earlier_one_when_the_disk_fills() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.adumbra");
        fs::write(&path, "earlier").unwrap();
        let result = replace_file(&path, |file| {
            file.write_all(b"half")?;
            Err(ErrorKind::StorageFull.into())
        });
        let Err(Error::Io { action: "write", source, .. }) = result else { panic!("{result:?}") };
        assert_eq!(source.kind(), ErrorKind::StorageFull);
        assert!(source.to_string().contains("free some space"));
        assert_eq!(fs::read(&path).unwrap(), b"earlier");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn same_file_is_known_under_any_spelling() {
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
    fn same_file_is_known_by_its_links() {
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
    fn staged_files_leave_earlier_ones_until_they_are_placed() {
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
        assert!(says("here").contains("symbolic links do not end"), "{}", says("here"));
        assert!(check_output(&at("here")).is_err());
        assert_eq!(fs::read_dir(at("store")).unwrap().count(), 2);
    }
}
