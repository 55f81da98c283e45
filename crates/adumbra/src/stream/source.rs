//! Sources of a file's bytes.

use std::fs::{File, Metadata};
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

use crate::error::{IoError, Result};

/// Yields ranges of a file's bytes: from a file on a disk, from memory, or from a server through the
/// program's own client.
///
/// A source on a server requests a range (`Range: bytes=0-65535`), and returns [`SourceError::Changed`] if
/// the server's `ETag` is not that of the first answer, or if the server answers 412.
pub trait ShadowSource: Send + Sync {
    /// Returns the bytes of a range, and fewer only where the file ends. It is called on threads that may
    /// block.
    ///
    /// # Errors
    /// Returns why the bytes cannot be read. They are requested again later, except after
    /// [`SourceError::Changed`].
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError>;
}

impl<S: ShadowSource + ?Sized> ShadowSource for Box<S> {
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError> {
        (**self).read(range)
    }
}

impl<S: ShadowSource + ?Sized> ShadowSource for Arc<S> {
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError> {
        (**self).read(range)
    }
}

/// Why a source yields no bytes.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// Reading failed, and may work later.
    #[error("reading failed: {0}")]
    Failed(Box<dyn std::error::Error + Send + Sync>),
    /// The file is not the one that was opened.
    #[error("the file has changed since it was opened; open it again")]
    Changed,
}

impl From<std::io::Error> for SourceError {
    fn from(error: std::io::Error) -> Self {
        Self::Failed(Box::new(error))
    }
}

/// A file on a disk.
#[derive(Debug)]
pub struct FileSource {
    file: Mutex<File>,
    state: FileState,
}

/// Metadata that changes when a file is written.
#[derive(Debug, PartialEq, Eq)]
struct FileState {
    bytes: u64,
    modified: Option<SystemTime>,
}

impl FileState {
    fn of(metadata: &Metadata) -> Self {
        Self { bytes: metadata.len(), modified: metadata.modified().ok() }
    }
}

impl FileSource {
    /// Opens a file. Nothing is read yet. If another file takes its name, the opened file is still read.
    ///
    /// # Errors
    /// Returns [`Error::Io`](crate::Error::Io) if the operating system does not open it.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let file = File::open(path).map_err(IoError::at("read", path))?;
        let state = FileState::of(&file.metadata().map_err(IoError::at("read", path))?);
        Ok(Self { file: Mutex::new(file), state })
    }
}

impl ShadowSource for FileSource {
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError> {
        let mut file = self.file.lock().unwrap_or_else(|e| e.into_inner());
        if FileState::of(&file.metadata()?) != self.state {
            return Err(SourceError::Changed);
        }
        file.seek(SeekFrom::Start(range.start))?;
        let mut bytes = Vec::new();
        (&mut *file).take(range.end.saturating_sub(range.start)).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

/// A file's bytes in memory, or in a memory map: anything that is a slice of bytes.
#[derive(Clone, Copy, Debug)]
pub struct BytesSource<B>(pub B);

impl<B: AsRef<[u8]> + Send + Sync> ShadowSource for BytesSource<B> {
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError> {
        let bytes = self.0.as_ref();
        let [start, end] =
            [range.start, range.end].map(|at| usize::try_from(at).unwrap_or(usize::MAX).min(bytes.len()));
        Ok(bytes[start..end.max(start)].to_vec())
    }
}
