//! The bytes of a glTF scene: the GLB container, buffers in files and in data URIs, and views into them.

use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;

use ::gltf::json::{Root, buffer};
use serde_json::Value;

use super::meshopt;
use crate::LoadNotes;
use crate::error::{Error, Result};
use crate::gltf::faults::{Faults, bad};
use crate::gltf::uris;
use crate::sources::Sources;

/// The parts of a file.
pub(super) struct Container<'a> {
    /// The JSON, without a byte-order mark and without padding.
    pub(super) json: &'a [u8],
    /// The binary chunk.
    pub(super) bin: Option<&'a [u8]>,
    /// The other chunks of a `.glb`, with their headers.
    pub(super) others: Vec<&'a [u8]>,
}

/// Chunk type of the JSON of a `.glb`.
const JSON: u32 = u32::from_le_bytes(*b"JSON");
/// Chunk type of the binary data.
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");
/// Chunks of other types are skipped (glTF 2.0, 4.4.3). A file with more of them than this is rejected.
const MAX_CHUNKS: usize = 1024;

/// Returns the JSON and the binary chunk of a `.glb`, or the JSON alone of a `.gltf`. The container's lengths
/// are checked first. If the file continues after its stated end, only the bytes up to that end are read.
///
/// # Errors
/// Returns [`Error::GltfVersion`] for version 1 of the container, and [`Error::SceneParse`] if it is broken.
pub(super) fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<Container<'a>> {
    if !bytes.starts_with(b"glTF") {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb")) {
            return Err(bad(path, "it does not begin with the letters glTF"));
        }
        return Ok(Container { json: bare(bytes), bin: None, others: Vec::new() });
    }
    let cut_off = |length: usize| {
        bad(path, format!("it is cut off: only {} of {length} bytes are present", bytes.len()))
    };
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(bad(path, "it is cut off within its header"));
    };
    match version {
        2 => {}
        1 => return Err(Error::GltfVersion { path: path.to_owned(), version: "1.0".to_owned() }),
        _ => {
            return Err(bad(
                path,
                format!("it has container version {version}; only version 2 is supported"),
            ));
        }
    }
    if length < 12 {
        return Err(bad(path, format!("its header states a length of {length} bytes")));
    }
    let whole = bytes.get(..length as usize).ok_or_else(|| cut_off(length as usize))?;
    let (mut json, mut bin, mut others, mut at) = (None, None, Vec::new(), 12);
    // Trailing bytes that are too few for a chunk header are padding.
    while let (Some(length), Some(kind)) = (word(whole, at), word(whole, at + 4)) {
        let end = at + 8 + length as usize;
        let data = whole.get(at + 8..end).ok_or_else(|| cut_off(end))?;
        match kind {
            JSON if json.is_none() => json = Some(data),
            BIN if bin.is_none() => bin = Some(data),
            _ if others.len() == MAX_CHUNKS => return Err(bad(path, "it has too many chunks")),
            _ => others.push(&whole[at..end]),
        }
        at = end;
    }
    let json = json.ok_or_else(|| bad(path, "it has no JSON chunk"))?;
    Ok(Container { json: bare(json), bin, others })
}

/// Strips the byte-order mark before the JSON, and the spaces or zeros that pad its chunk.
fn bare(json: &[u8]) -> &[u8] {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let end = json.iter().rposition(|&b| b != 0 && !b.is_ascii_whitespace()).map_or(0, |last| last + 1);
    &json[..end]
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes)
}

/// Why a buffer could not be read.
struct Failure {
    text: String,
    /// The error; `None` once it has been returned to a user of the buffer.
    error: Option<Error>,
}

/// All buffers of the scene.
pub(super) struct Buffers<'a> {
    /// The scene's files and the memory budget of the load.
    pub(super) sources: &'a Sources<'a>,
    path: &'a Path,
    /// The elements of the file that cannot be read.
    pub(super) faults: &'a Faults,
    /// `None` for a buffer whose raw bytes no view needs, and for a buffer that could not be read.
    bytes: Vec<Option<Cow<'a, [u8]>>>,
    /// Why buffers could not be read.
    failed: RefCell<BTreeMap<usize, Failure>>,
    /// The views that were compressed, decoded when they were first used.
    #[cfg(feature = "meshopt")]
    decoded: Vec<std::cell::OnceCell<Vec<u8>>>,
}

impl<'a> Buffers<'a> {
    /// Reads the buffers that are not in the file itself, except fallback buffers of compressed views. A
    /// buffer that cannot be read is an error only where a view of it is used.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`].
    pub(super) fn load(
        sources: &'a Sources<'a>,
        root: &Root,
        faults: &'a Faults,
        mut bin: Option<&'a [u8]>,
        notes: &mut LoadNotes,
    ) -> Result<Self> {
        let needed = needed_buffers(root);
        let mut bytes = Vec::with_capacity(root.buffers.len());
        let mut failed = BTreeMap::new();
        for (index, buffer) in root.buffers.iter().enumerate() {
            let stated = buffer.byte_length.0;
            let bin = if index == 0 && buffer.uri.is_none() { bin.take() } else { None };
            if !needed[index] {
                bytes.push(None);
                continue;
            }
            let data = match (&buffer.uri, bin) {
                (Some(uri), _) => match uris::read(sources, uri, &format!("buffer {index}"), stated) {
                    Ok(read) => Cow::Owned(read),
                    Err(e @ Error::SceneMemory { .. }) => return Err(e),
                    Err(e) => {
                        failed.insert(index, Failure { text: e.to_string(), error: Some(e) });
                        bytes.push(None);
                        continue;
                    }
                },
                (None, Some(bin)) => Cow::Borrowed(bin),
                (None, None) if is_fallback(buffer) => {
                    bytes.push(None);
                    continue;
                }
                (None, None) => Cow::default(),
            };
            if (data.len() as u64) < stated {
                // A view that reaches past the buffer's end is an error later.
                notes.warnings.push(format!("buffer {index} has {} bytes, not {stated}", data.len()));
            }
            bytes.push(Some(data));
        }
        Ok(Self {
            sources,
            path: sources.scene,
            faults,
            bytes,
            failed: RefCell::new(failed),
            #[cfg(feature = "meshopt")]
            decoded: root.buffer_views.iter().map(|_| Default::default()).collect(),
        })
    }

    /// Total size of all buffers, bytes: an upper bound on the data that the file can describe.
    pub(super) fn total(&self) -> u64 {
        self.bytes.iter().flatten().map(|b| b.len() as u64).sum()
    }

    /// The bytes of a buffer view, decoded if they are compressed.
    pub(super) fn view<'s>(&'s self, root: &'s Root, index: usize) -> Result<(&'s [u8], &'s buffer::View)> {
        let Some(view) = root.buffer_views.get(index) else {
            return Err(bad(self.path, format!("buffer view {index} does not exist")));
        };
        self.faults.check(self.path, "buffer view", index)?;
        #[cfg(feature = "meshopt")]
        if let Some((extension, json)) = compression(view) {
            return Ok((self.decode(index, view, extension, json)?, view));
        }
        let buffer = view.buffer.value();
        self.readable(buffer)?;
        if let Some(None) = self.bytes.get(buffer) {
            if let Some((what, _)) = compression(view) {
                return Err(Error::MissingFeature { path: self.path.to_owned(), what, feature: "meshopt" });
            }
            return Err(bad(
                self.path,
                format!("buffer view {index} is in buffer {buffer}, which has no data"),
            ));
        }
        let bytes = self.slice(buffer, view.byte_offset.map_or(0, |o| o.0), view.byte_length.0);
        match bytes {
            Some(bytes) => Ok((bytes, view)),
            None => Err(bad(self.path, format!("buffer view {index} reaches past its buffer"))),
        }
    }

    #[cfg(feature = "meshopt")]
    fn decode(
        &self,
        index: usize,
        view: &buffer::View,
        extension: &'static str,
        json: &Value,
    ) -> Result<&[u8]> {
        let cell = self.decoded.get(index).ok_or_else(|| bad(self.path, "it has too many buffer views"))?;
        if let Some(decoded) = cell.get() {
            return Ok(decoded);
        }
        let broken = |what: String| bad(self.path, format!("buffer view {index} cannot be decoded: {what}"));
        let stride = view.byte_stride.map(|s| s.0 as u64);
        let compressed = meshopt::Compressed::read(extension, json, stride).map_err(broken)?;
        self.readable(compressed.buffer)?;
        let bytes = self
            .slice(compressed.buffer, compressed.byte_offset, compressed.byte_length)
            .ok_or_else(|| broken(format!("its {extension} reaches past its buffer")))?;
        let size = compressed.decoded_bytes();
        self.sources.budget.charge(size, || format!("the decoded buffer view {index}"))?;
        let decoded = compressed.decode(bytes).map_err(broken)?;
        Ok(cell.get_or_init(|| decoded))
    }

    /// An error if the buffer could not be read.
    fn readable(&self, buffer: usize) -> Result<()> {
        self.faults.check(self.path, "buffer", buffer)?;
        match self.failed.borrow_mut().get_mut(&buffer) {
            Some(Failure { text, error }) => {
                Err(error.take().unwrap_or_else(|| bad(self.path, text.as_str())))
            }
            None => Ok(()),
        }
    }

    /// A warning about the buffers that could not be read, once it is known that none of them was needed.
    pub(super) fn warning(&self) -> Option<String> {
        let failed = self.failed.borrow();
        let mut unused = failed.iter().filter(|(_, failure)| failure.error.is_some());
        let (index, first) = unused.next()?;
        Some(format!(
            "buffers that cannot be read, and that nothing needs: {}; buffer {index}: {}",
            1 + unused.count(),
            first.text
        ))
    }

    fn slice(&self, buffer: usize, from: u64, length: u64) -> Option<&[u8]> {
        let to = from.checked_add(length)?;
        let range = usize::try_from(from).ok()?..usize::try_from(to).ok()?;
        self.bytes.get(buffer)?.as_ref()?.get(range)
    }
}

/// For each buffer, whether a view needs it. A view that is decoded needs only the buffer of its compressed
/// bytes.
fn needed_buffers(root: &Root) -> Vec<bool> {
    let mut needed = vec![false; root.buffers.len()];
    for view in &root.buffer_views {
        let others = view.extensions.as_ref().map(|e| &e.others);
        let compressed = others.and_then(meshopt::buffer).filter(|_| cfg!(feature = "meshopt"));
        if let Some(needed) = needed.get_mut(compressed.unwrap_or(view.buffer.value())) {
            *needed = true;
        }
    }
    needed
}

/// How a buffer view is compressed, if it is: the extension's name, and its JSON.
fn compression(view: &buffer::View) -> Option<(&'static str, &Value)> {
    meshopt::extension(&view.extensions.as_ref()?.others)
}

/// Whether a buffer is only a fallback for compressed data, so that it may be missing.
fn is_fallback(buffer: &buffer::Buffer) -> bool {
    buffer.extensions.as_ref().is_some_and(|e| meshopt::is_fallback(&e.others))
}
