//! Ranges of an asset.

use std::io::{self, SeekFrom};
use std::ops::Range;

use adumbra::stream::SourceError;
use async_channel::{Receiver, Sender};
use bevy::asset::io::{AssetReaderError, AssetSourceId, Reader, VecReader};
use bevy::asset::{AssetPath, AssetServer, AssetServerMode, AsyncReadExt, AsyncSeekExt};
use bevy::log::warn;

/// The result of reading a range.
pub(super) type Read = Result<Vec<u8>, SourceError>;

/// A requested range, and the channel for its bytes.
pub(super) type Asked = (Range<u64>, Sender<Read>);

/// Reads requested ranges of an asset until the channel closes. The asset stays open; after an error it is
/// reopened.
pub(super) async fn serve(server: AssetServer, path: AssetPath<'static>, asked: Receiver<Asked>) {
    let mut reader = None;
    let mut length = None;
    while let Ok((range, answer)) = asked.recv().await {
        let read = async {
            let reader = match &mut reader {
                Some(reader) => reader,
                None => reader.insert(open(&server, &path).await?),
            };
            read(reader, range, &mut length).await
        };
        let result = read.await;
        if result.is_err() {
            reader = None;
        }
        // The receiver may have been dropped with its stream; ignore it.
        let _ = answer.send(result).await;
    }
}

/// Opens an asset with a reader that can seek.
async fn open<'a>(
    server: &'a AssetServer,
    path: &'a AssetPath<'static>,
) -> Result<Box<dyn Reader + 'a>, SourceError> {
    let failed = |error: AssetReaderError| SourceError::Failed(error.into());
    let source = server.get_source(path.source()).map_err(|error| SourceError::Failed(error.into()))?;
    let reader = match server.mode() {
        AssetServerMode::Unprocessed => source.reader(),
        AssetServerMode::Processed => {
            source.processed_reader().map_err(|error| SourceError::Failed(error.into()))?
        }
    };
    let mut reader = reader.read(path.path()).await.map_err(failed)?;
    if matches!(path.source(), AssetSourceId::Name(name) if matches!(&**name, "http" | "https")) {
        warn_of_no_ranges(path);
    }
    if reader.seekable().is_ok() {
        return Ok(reader);
    }
    warn_of_no_ranges(path);
    let mut bytes = Vec::new();
    Reader::read_to_end(&mut reader, &mut bytes).await?;
    Ok(Box::new(VecReader::new(bytes)))
}

fn warn_of_no_ranges(path: &AssetPath) {
    warn!(
        "the asset source of {path} has no ranges, so the whole file is read; give BakedShadow::streamed a source that has \
         them: StreamSource::ranges"
    );
}

/// Reads a range. `length` is the asset's length when it was first opened.
async fn read(reader: &mut Box<dyn Reader + '_>, range: Range<u64>, length: &mut Option<u64>) -> Read {
    let reader = reader.seekable().map_err(io::Error::other)?;
    let end = reader.seek(SeekFrom::End(0)).await?;
    if *length.get_or_insert(end) != end {
        return Err(SourceError::Changed);
    }
    let wanted = range.end.min(end).saturating_sub(range.start);
    reader.seek(SeekFrom::Start(range.start)).await?;
    let mut bytes = vec![0; usize::try_from(wanted).map_err(io::Error::other)?];
    reader.read_exact(&mut bytes).await?;
    Ok(bytes)
}
