//! `adumbra export`: a shadow file as a web page fetches it, and compressed beside it.
//!
//! Servers and bundlers send `NAME.br` with `Content-Encoding: br` where it lies next to the file. Brotli at its highest
//! quality takes minutes for large files, so it is done once, here, and not for every visitor.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use adumbra::{AtRest, Error, IoError, ShadowFile};
use adumbra_files::{StagedFile, same_file};
use adumbra_program::exit::{Code, Outcome};
use adumbra_program::output::{format_bytes, print_json, refuse_same};
use adumbra_program::say;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Export;

/// Brotli's highest quality, and the largest window that browsers accept: 2^24 bytes.
const QUALITY: u32 = 11;
const WINDOW_BITS: u32 = 24;
/// Bytes that are compressed at a time.
const BUFFER_BYTES: usize = 1 << 16;

/// The files for a web page.
#[derive(Serialize, JsonSchema)]
pub(super) struct WebExported {
    /// The shadow file that was read.
    file: String,
    /// The copy that a page fetches.
    web: String,
    /// Bytes of the copy.
    web_bytes: u64,
    /// The copy compressed with Brotli.
    compressed: String,
    /// Bytes that a page fetches from a server that sends the compressed copy.
    compressed_bytes: u64,
}

pub(crate) fn run(args: &Export) -> Outcome {
    let web = &*args.web;
    let length = fs::metadata(&args.file).map_err(IoError::at("read", &args.file))?.len();
    // The bytes, the decoded file, and what compression holds.
    args.run.check_memory("the shadow file", 0, 8 * length + compression_bytes(length))?;
    let error = |e| Error::Format { path: args.file.clone(), source: Box::new(e) };
    let found = fs::read(&args.file).map_err(IoError::at("read", &args.file))?;
    // Pages decode Brotli themselves, and a coded file would not become smaller by it.
    let bytes = ShadowFile::from_bytes(&found).and_then(|file| file.to_bytes(AtRest::Raw)).map_err(error)?;
    let compressed = compressed_path(web);
    refuse_same([&*args.file, &*compressed])?;
    refuse_same([web, &*compressed])?;
    let mut staged = Vec::new();
    if !same_file(&args.file, web) || bytes != found {
        staged.push(StagedFile::new(web, |out| out.write_all(&bytes).map(|()| bytes.len() as u64))?);
    }
    let squeezed = StagedFile::new(&compressed, |out| {
        let mut counted = Counted { out, bytes: 0 };
        let mut writer = brotli::CompressorWriter::new(&mut counted, BUFFER_BYTES, QUALITY, WINDOW_BITS);
        writer.write_all(&bytes)?;
        writer.flush()?;
        drop(writer);
        Ok(counted.bytes)
    })?;
    let compressed_bytes = squeezed.bytes();
    staged.push(squeezed);
    StagedFile::place(staged)?;
    if args.run.json {
        print_json(&WebExported {
            file: args.file.display().to_string(),
            web: web.display().to_string(),
            web_bytes: bytes.len() as u64,
            compressed: compressed.display().to_string(),
            compressed_bytes,
        })?;
    } else {
        say!(
            "{}: {}; {}: {}",
            web.display(),
            format_bytes(bytes.len() as u64),
            compressed.display(),
            format_bytes(compressed_bytes)
        );
        say!("{}", lines_to_paste(web));
    }
    Ok(Code::Fine)
}

/// Memory that Brotli takes at these settings, measured: 16 times what is in its window, and 16 MiB.
fn compression_bytes(length: u64) -> u64 {
    (16 << 20) + 16 * length.min(1 << WINDOW_BITS)
}

/// The path of the compressed copy: that of the copy with `.br` added to it.
fn compressed_path(web: &Path) -> PathBuf {
    let mut path = web.as_os_str().to_owned();
    path.push(".br");
    path.into()
}

/// What a page needs, for three.js.
fn lines_to_paste(web: &Path) -> String {
    let name = web.file_name().unwrap_or_default().to_string_lossy();
    format!(
        "
Serve both files from one folder, the compressed one as {name} with Content-Encoding: br. In the page:

import {{ ShadowFileLoader }} from 'adumbra-three';
import {{ BakedShadowNode }} from 'adumbra-three/webgpu';

const file = await new ShadowFileLoader().loadAsync('{name}');
renderer.shadowMap.enabled = sun.castShadow = true;
sun.shadow.shadowNode = new BakedShadowNode(sun, {{ file }});

With WebGLRenderer:

import {{ attachBakedShadow }} from 'adumbra-three/webgl';
attachBakedShadow(scene, sun, file);"
    )
}

/// Counts what is written.
struct Counted<W> {
    out: W,
    bytes: u64,
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}
