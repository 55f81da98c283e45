//! Pages as files: page 0 at the path, page n with its number before the ending (`out.png`, `out.1.png`, `out.2.png` …).

use std::fs::File;
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use super::join::Joiner;
use super::png::{HEADER_BYTES, check_header};
use super::{Layout, Page, Stream, TextureError};
use crate::error::{Error, Result};
use crate::files::{check_output, replace_file};

/// What [`write()`] wrote.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// Sizes and number of the pages.
    pub layout: Layout,
    /// Bytes of all PNGs.
    pub bytes: u64,
}

/// Where page `page` of the export at `path` is.
pub fn page_path(path: &Path, page: u32) -> PathBuf {
    match (page, path.extension()) {
        (0, _) => path.to_owned(),
        (_, Some(ending)) => path.with_extension(format!("{page}.{}", ending.to_string_lossy())),
        (_, None) => path.with_extension(page.to_string()),
    }
}

/// Writes `words` and `rest` as PNG pages at `path` and beside it; see [`super::encode`].
///
/// Each file is there whole or not at all, page 0 last: until it is replaced, an earlier export's page 0 stands, and its
/// checksums tell that later pages are not its own. Pages of an earlier, longer export are left; nothing reads them.
///
/// # Errors
/// [`Error::Io`] where the system refuses, [`Error::WordTexture`] where the words do not fit.
pub fn write(path: &Path, words: &[u32], rest: &[u8], max_side: u32) -> Result<Written> {
    let refused = |source| Error::WordTexture { path: path.to_owned(), source };
    let stream = Stream::new(words, rest, max_side).map_err(refused)?;
    let layout = stream.layout;
    for page in 0..layout.pages {
        check_output(&page_path(path, page))?;
    }
    let mut bytes = 0;
    for page in (0..layout.pages).rev() {
        let pixels = stream.page(page);
        bytes += replace_file(&page_path(path, page), |file| {
            let mut out = BufWriter::new(&mut *file);
            pixels.write_png(&mut out)?;
            out.flush()?;
            drop(out);
            Ok(file.metadata()?.len())
        })?;
    }
    Ok(Written { layout, bytes })
}

/// Reads what [`write()`] wrote at `path`: the words and the rest, bit for bit.
///
/// # Errors
/// [`Error::Io`] where the system refuses, [`Error::WordTexture`] with the page's file where it is not what was written.
pub fn read(path: &Path) -> Result<(Vec<u32>, Vec<u8>)> {
    let mut joiner = Joiner::default();
    while let Some(page) = joiner.next_page() {
        let path = page_path(path, page);
        let refused = |source| Error::WordTexture { path: path.clone(), source };
        let pixels = match read_page(&path) {
            Err(Error::Io { source, .. }) if page > 0 && source.kind() == ErrorKind::NotFound => {
                let pages = joiner.pages();
                return Err(refused(TextureError::MissingPage { page, pages }));
            }
            other => other?,
        };
        joiner.add(&pixels).map_err(refused)?;
    }
    joiner.finish().map_err(|source| Error::WordTexture { path: path.to_owned(), source })
}

/// Reads one PNG. Its header is read first, so a large file of another kind is refused without being read.
fn read_page(path: &Path) -> Result<Page> {
    let refused = |source| Error::WordTexture { path: path.to_owned(), source };
    let mut file = File::open(path).map_err(Error::io("read", path))?;
    let mut bytes = Vec::new();
    (&mut file).take(HEADER_BYTES as u64).read_to_end(&mut bytes).map_err(Error::io("read", path))?;
    let [width, height] = check_header(&bytes).map_err(refused)?;
    // Twice the pixels and a mebibyte are more than any encoder needs; what comes behind is not read.
    let limit = u64::from(width) * u64::from(height) * 8 + (1 << 20);
    file.take(limit).read_to_end(&mut bytes).map_err(Error::io("read", path))?;
    Page::from_png(&bytes).map_err(refused)
}
