//! Files that are there whole or not at all: a temporary file beside the target takes its name once it is complete. A symbolic link is
//! followed: the file that it leads to is replaced, and the link stays.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// Most symbolic links that are followed from one to the next, as Linux does it.
const MAX_LINKS: usize = 40;

/// Has `write` fill a temporary file beside `path`, syncs it, and gives it that name; returns what `write` returns.
///
/// # Errors
/// [`Error::Io`] where the system refuses; the temporary file is removed and what was at `path` stays as it was.
pub fn replace_file(path: &Path, write: impl FnOnce(&mut File) -> io::Result<u64>) -> Result<u64> {
    let target = target_of(path).map_err(Error::io("create", path))?;
    let mut temporary = temporary_beside(path, &target)?;
    let written = write(temporary.as_file_mut())
        .and_then(|bytes| temporary.as_file().sync_all().map(|()| bytes))
        .map_err(with_mend)
        .map_err(Error::io("write", path))?;
    temporary.persist(&target).map_err(|e| with_mend(e.error)).map_err(Error::io("replace", path))?;
    Ok(written)
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
    if let (Some(a), Some(b)) = (identity(a), identity(b)) {
        return a == b;
    }
    let place = |path: &Path| {
        let target = target_of(path).ok()?;
        Some(folder_of(&target).canonicalize().ok()?.join(target.file_name()?))
    };
    matches!((place(a), place(b)), (Some(a), Some(b)) if a == b)
}

/// What hard links to a file have in common.
#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(path).ok().map(|found| (found.dev(), found.ino()))
}

/// What spellings of a file's path have in common; its hard links are not known.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}

/// The folder that a file at `path` lies in.
pub fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// An empty temporary file in the folder of `target`, to which `path` leads; it goes away with the value.
fn temporary_beside(path: &Path, target: &Path) -> Result<NamedTempFile> {
    let folder = folder_of(target);
    check_target(target, &folder).map_err(Error::io("create", path))?;
    let mut builder = tempfile::Builder::new();
    builder.prefix(".adumbra-").suffix(".tmp");
    // As an ordinary new file, less the umask; the default is for secrets.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(&folder).map_err(with_mend).map_err(Error::io("create", path))
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
