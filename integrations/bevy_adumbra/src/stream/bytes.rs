//! Bytes of a streamed file, read without blocking Bevy's threads.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use adumbra::stream::{FileSource, ShadowSource, SourceError};
use async_channel::{Sender, bounded, unbounded};
use bevy::asset::AssetServer;
use bevy::tasks::{IoTaskPool, Task};

use super::asset::{Asked, Read, serve};
use crate::StreamSource;

/// Bytes of a streamed file.
pub(super) enum Bytes {
    /// A task reads them. It ends when this is dropped.
    Asset { asked: Sender<Asked>, _task: Task<()> },
    /// They are read on threads that may block.
    Ranges(Arc<dyn ShadowSource>),
}

impl Bytes {
    /// Prepares to read. Nothing is opened yet.
    pub(super) fn new(source: &StreamSource, server: &AssetServer) -> Self {
        match source {
            StreamSource::Asset(path) => {
                let (asked, receiver) = unbounded();
                let task = IoTaskPool::get().spawn(serve(server.clone(), path.clone(), receiver));
                Self::Asset { asked, _task: task }
            }
            StreamSource::Disk(path) => {
                Self::Ranges(Arc::new(DiskFile { path: path.clone(), file: Mutex::default() }))
            }
            StreamSource::Ranges(source) => Self::Ranges(Arc::clone(source)),
        }
    }

    /// Reads a range.
    pub(super) async fn read(&self, range: Range<u64>) -> Read {
        match self {
            Self::Asset { asked, .. } => {
                let (answer, read) = bounded(1);
                let ended = |_| SourceError::Failed("the task that reads the asset has ended".into());
                asked.send((range, answer)).await.map_err(|error| ended(error.to_string()))?;
                read.recv().await.map_err(|error| ended(error.to_string()))?
            }
            Self::Ranges(source) => {
                let source = Arc::clone(source);
                blocking::unblock(move || source.read(range)).await
            }
        }
    }
}

/// A file on a disk that is opened on the first read.
struct DiskFile {
    path: PathBuf,
    file: Mutex<Option<Arc<FileSource>>>,
}

impl ShadowSource for DiskFile {
    fn read(&self, range: Range<u64>) -> Read {
        let mut file = self.file.lock().unwrap_or_else(|e| e.into_inner());
        let open = match &*file {
            Some(open) => Arc::clone(open),
            None => {
                let open = FileSource::open(&self.path).map_err(|error| SourceError::Failed(error.into()))?;
                Arc::clone(file.insert(Arc::new(open)))
            }
        };
        drop(file);
        open.read(range)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::pin::Pin;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::task::{Context, Poll};

    use bevy::MinimalPlugins;
    use bevy::app::App;
    use bevy::asset::io::{
        AssetReader, AssetReaderError, AssetSourceBuilder, PathStream, Reader, ReaderNotSeekableError,
        SeekableReader, VecReader,
    };
    use bevy::asset::{AssetApp, AssetPlugin};
    use bevy::tasks::block_on;
    use bevy::tasks::futures_lite::AsyncRead;

    use super::*;

    /// An asset source whose readers cannot seek, and how often it was read.
    struct WithoutRanges(Arc<AtomicUsize>);

    struct Forwards(VecReader);

    impl AsyncRead for Forwards {
        fn poll_read(
            mut self: Pin<&mut Self>,
            context: &mut Context<'_>,
            to: &mut [u8],
        ) -> Poll<std::io::Result<usize>> {
            Pin::new(&mut self.0).poll_read(context, to)
        }
    }

    impl Reader for Forwards {
        fn seekable(&mut self) -> Result<&mut dyn SeekableReader, ReaderNotSeekableError> {
            Err(ReaderNotSeekableError)
        }
    }

    impl AssetReader for WithoutRanges {
        async fn read<'a>(&'a self, path: &'a Path) -> Result<impl Reader + 'a, AssetReaderError> {
            self.0.fetch_add(1, Ordering::SeqCst);
            if path == Path::new("none") {
                return Err(AssetReaderError::NotFound(path.to_owned()));
            }
            Ok(Forwards(VecReader::new((0..200).collect())))
        }

        async fn read_meta<'a>(&'a self, path: &'a Path) -> Result<impl Reader + 'a, AssetReaderError> {
            Err::<VecReader, _>(AssetReaderError::NotFound(path.to_owned()))
        }

        async fn read_directory<'a>(&'a self, path: &'a Path) -> Result<Box<PathStream>, AssetReaderError> {
            Err(AssetReaderError::NotFound(path.to_owned()))
        }

        async fn is_directory<'a>(&'a self, _: &'a Path) -> Result<bool, AssetReaderError> {
            Ok(false)
        }
    }

    #[test]
    fn reads_an_unseekable_asset_once_and_retries_a_missing_one() {
        let reads = Arc::new(AtomicUsize::new(0));
        let of_source = Arc::clone(&reads);
        let mut app = App::new();
        let source = AssetSourceBuilder::new(move || Box::new(WithoutRanges(Arc::clone(&of_source))));
        app.register_asset_source("forwards", source).add_plugins((MinimalPlugins, AssetPlugin::default()));
        let server = app.world().resource::<AssetServer>();
        let bytes = Bytes::new(&StreamSource::from("forwards://file"), server);
        let read = |range: Range<u64>| block_on(bytes.read(range)).unwrap();
        assert_eq!(read(0..3), [0, 1, 2]);
        assert_eq!(read(100..102), [100, 101]);
        assert_eq!(read(198..1000), [198, 199]);
        assert_eq!(reads.load(Ordering::SeqCst), 1);
        let bytes = Bytes::new(&StreamSource::from("forwards://none"), server);
        for _ in 0..2 {
            let error = block_on(bytes.read(0..3)).unwrap_err();
            assert!(error.to_string().contains("none"), "{error}");
        }
        assert_eq!(reads.load(Ordering::SeqCst), 3);
    }
}
