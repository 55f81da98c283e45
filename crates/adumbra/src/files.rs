//! Files that are there whole or not at all: a temporary file beside the target takes its name once it is complete.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// Has `write` fill a temporary file beside `path`, syncs it, and gives it that name; returns what `write` returns.
///
/// # Errors
/// [`Error::Io`] where the system refuses; the temporary file is removed and what was at `path` stays as it was.
pub fn replace_file(path: &Path, write: impl FnOnce(&mut File) -> io::Result<u64>) -> Result<u64> {
    let mut temporary = temporary_beside(path)?;
    let written = write(temporary.as_file_mut())
        .and_then(|bytes| temporary.as_file().sync_all().map(|()| bytes))
        .map_err(with_mend)
        .map_err(Error::io("write", path))?;
    temporary.persist(path).map_err(|e| with_mend(e.error)).map_err(Error::io("replace", path))?;
    Ok(written)
}

/// Whether a file could be written at `path`; touches nothing that is there.
///
/// # Errors
/// [`Error::Io`] as [`replace_file`] would give it.
pub fn check_output(path: &Path) -> Result<()> {
    temporary_beside(path).map(|_| ())
}

/// The folder that a file at `path` lies in.
pub fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// An empty temporary file in the folder of `path`; it goes away with the value.
fn temporary_beside(path: &Path) -> Result<NamedTempFile> {
    let folder = folder_of(path);
    check_target(path, &folder).map_err(Error::io("create", path))?;
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
}
