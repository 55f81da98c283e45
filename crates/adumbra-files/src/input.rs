//! Files that are read whole.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use adumbra::IoError;

/// Most bytes of a text file with instructions, such as a camera, edits or suns.
pub const TEXT_BYTES: u64 = 64 << 20;

/// Reads a whole file, or a pipe to its end. Refuses a device, which may have no end, and more than
/// `most_bytes`.
///
/// # Errors
/// Returns [`IoError`] if the operating system fails to read, or if the file is refused.
pub fn read_whole(path: &Path, most_bytes: u64) -> Result<Vec<u8>, IoError> {
    read(path, most_bytes).map_err(IoError::at("read", path))
}

/// Reads a text as [`read_whole`] does.
///
/// # Errors
/// Returns the errors of [`read_whole`], and [`IoError`] if the bytes are not UTF-8.
pub fn read_text(path: &Path, most_bytes: u64) -> Result<String, IoError> {
    let invalid = |error: std::string::FromUtf8Error| io::Error::new(ErrorKind::InvalidData, error);
    String::from_utf8(read_whole(path, most_bytes)?).map_err(invalid).map_err(IoError::at("read", path))
}

fn read(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    let refuse = |kind, what: String| Err(io::Error::new(kind, what));
    let file = File::open(path)?;
    let found = file.metadata()?;
    if found.is_dir() {
        return refuse(ErrorKind::IsADirectory, "it is a folder; give a file".to_owned());
    }
    if is_device(&found) {
        return refuse(ErrorKind::InvalidInput, "it is a device; give a file".to_owned());
    }
    let mut bytes = Vec::new();
    file.take(most_bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        return refuse(
            ErrorKind::InvalidData,
            format!("it has more than the {most_bytes} bytes that are allowed"),
        );
    }
    Ok(bytes)
}

#[cfg(unix)]
fn is_device(found: &std::fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    found.file_type().is_char_device() || found.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: &std::fs::Metadata) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_files_up_to_a_limit_and_rejects_devices() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, "five!").unwrap();
        assert_eq!(read_whole(&path, 5).unwrap(), b"five!");
        assert_eq!(read_text(&path, 5).unwrap(), "five!");
        let says = |path: &Path, most| read_whole(path, most).unwrap_err().to_string();
        assert!(says(&path, 4).contains("more than the 4 bytes"), "{}", says(&path, 4));
        assert!(says(folder.path(), 4).contains("folder"), "{}", says(folder.path(), 4));
        std::fs::write(&path, [0xff]).unwrap();
        assert!(read_text(&path, 5).unwrap_err().to_string().contains("file"));
        #[cfg(unix)]
        assert!(says(Path::new("/dev/zero"), u64::MAX).contains("device"));
    }
}
