//! Pages as files: page 0 at the path itself, page n with its number before the extension
//! (`out.png`, `out.1.png`, `out.2.png` …).

use adumbra::IoError;
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use crate::tree::error::TextureError;
use crate::tree::error::{Error, Result};
use crate::tree::texture::join::Joiner;
use crate::tree::texture::png::{HEADER_BYTES, check_header};
use crate::tree::texture::{Layout, Page, Stream};
use adumbra_files::{StagedFile, check_output, first_same};

/// The result of [`write()`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExportSummary {
    /// Size and number of the pages.
    pub layout: Layout,
    /// Total bytes of all PNGs.
    pub bytes: u64,
}

/// Returns the path of page `page` of the export at `path`.
pub fn page_path(path: &Path, page: u32) -> PathBuf {
    match (page, path.extension()) {
        (0, _) => path.to_owned(),
        (_, Some(ending)) => path.with_extension(format!("{page}.{}", ending.to_string_lossy())),
        (_, None) => path.with_extension(page.to_string()),
    }
}

/// Writes `words` and `rest` as PNG pages to `path` and next to it; see [`crate::tree::texture::encode`].
///
/// All files are written before any existing file is replaced, and page 0 is replaced last. Until then, page
/// 0 of an earlier export remains, and its checksums show that the later pages are not its own. Extra pages
/// of an earlier, longer export are not deleted; nothing reads them.
///
/// # Errors
/// Returns [`Error::Io`] if the operating system refuses or two pages are the same file, in which case an
/// earlier export is unchanged. Returns [`Error::WordTexture`] if the words do not fit.
pub fn write(path: &Path, words: &[u32], rest: &[u8], max_side: u32) -> Result<ExportSummary> {
    let refused = |source| Error::WordTexture { path: path.to_owned(), source };
    let stream = Stream::new(words, rest, max_side).map_err(refused)?;
    let layout = stream.layout;
    let paths: Vec<PathBuf> = (0..layout.pages).map(|page| page_path(path, page)).collect();
    paths.iter().try_for_each(|path| check_output(path))?;
    if let Some((first, second)) = first_same(paths.iter().map(PathBuf::as_path)) {
        let what = format!("it is the same file as \"{}\"; remove the link", first.display());
        return Err(IoError::at("create", second)(std::io::Error::new(ErrorKind::InvalidInput, what)).into());
    }
    let mut staged = Vec::with_capacity(paths.len());
    for (page, path) in (0..layout.pages).zip(&paths).rev() {
        let pixels = stream.page(page);
        staged.push(StagedFile::new(path, |file| {
            // The encoder's own error for a failed write does not preserve its kind.
            let mut out = Faults { inner: BufWriter::new(&mut *file), fault: None };
            let written = pixels.write_png(&mut out).and_then(|()| out.flush());
            if let Some(fault) = out.fault.take() {
                return Err(fault);
            }
            written?;
            drop(out);
            Ok(file.metadata()?.len())
        })?);
    }
    let bytes = staged.iter().map(StagedFile::bytes).sum();
    StagedFile::place(staged)?;
    Ok(ExportSummary { layout, bytes })
}

/// Keeps the first error of a writer.
struct Faults<W> {
    inner: W,
    fault: Option<std::io::Error>,
}

impl<W> Faults<W> {
    fn keep<T>(&mut self, result: std::io::Result<T>) -> std::io::Result<T> {
        result.map_err(|fault| {
            let passed_on = fault.kind().into();
            // An interrupted write is retried.
            if fault.kind() != ErrorKind::Interrupted {
                self.fault.get_or_insert(fault);
            }
            passed_on
        })
    }
}

impl<W: Write> Write for Faults<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let result = self.inner.write(bytes);
        self.keep(result)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        let result = self.inner.flush();
        self.keep(result)
    }
}

/// Reads the words and the rest that [`write()`] wrote at `path`, bit for bit.
///
/// # Errors
/// Returns [`Error::Io`] if the operating system refuses, and [`Error::WordTexture`] with the file of a page
/// that differs from the page written.
pub fn read(path: &Path) -> Result<(Vec<u32>, Vec<u8>)> {
    let mut joiner = Joiner::default();
    while let Some(page) = joiner.next_page() {
        let path = page_path(path, page);
        let refused = |source| Error::WordTexture { path: path.clone(), source };
        let pixels = match read_page(&path) {
            Err(Error::Io(e)) if page > 0 && e.source.kind() == ErrorKind::NotFound => {
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
    let mut file = File::open(path).map_err(IoError::at("read", path))?;
    let mut bytes = Vec::new();
    (&mut file).take(HEADER_BYTES as u64).read_to_end(&mut bytes).map_err(IoError::at("read", path))?;
    let [width, height] = check_header(&bytes).map_err(refused)?;
    // No encoder needs more than twice the pixels plus one mebibyte; anything beyond that is not read.
    let limit = u64::from(width) * u64::from(height) * 8 + (1 << 20);
    file.take(limit).read_to_end(&mut bytes).map_err(IoError::at("read", path))?;
    Page::from_png(&bytes).map_err(refused)
}
