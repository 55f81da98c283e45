//! The bytes of a glTF scene: the GLB container, buffers in files and in data URIs, and views into them.

use std::borrow::Cow;
use std::path::Path;

use ::gltf::binary::Glb;
use ::gltf::json::{Root, buffer};
use serde_json::Value;

use super::meshopt;
use crate::error::{Error, Result};
use crate::sources::Sources;

/// The JSON, and the binary chunk if there is one.
type Parts<'a> = (Cow<'a, [u8]>, Option<Cow<'a, [u8]>>);

/// Returns the JSON and the binary chunk of a `.glb`, or the JSON alone of a `.gltf`. The container's lengths are
/// checked first. If the file continues after its stated end, only the bytes up to that end are read.
pub(super) fn split<'a>(path: &Path, bytes: &'a [u8]) -> Result<Parts<'a>> {
    if !bytes.starts_with(b"glTF") {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb")) {
            return Err(bad(path, "it does not begin with the letters glTF"));
        }
        return Ok((Cow::Borrowed(bytes), None));
    }
    let word = |at: usize| -> Option<u32> { bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes) };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(bad(path, "it is cut off within its header"));
    };
    if version != 2 {
        return Err(bad(path, format!("it has container version {version}; only version 2 is supported")));
    }
    if length < 12 {
        return Err(bad(path, format!("its header states a length of {length} bytes")));
    }
    let Some(whole) = bytes.get(..length as usize) else {
        return Err(bad(path, format!("it is cut off: only {} of {length} bytes are present", bytes.len())));
    };
    let glb = Glb::from_slice(whole).map_err(|e| bad(path, e.to_string()))?;
    Ok((glb.json, glb.bin))
}

/// All buffers of the scene.
pub(super) struct Buffers<'a> {
    /// The scene's files and the memory budget of the load.
    pub(super) sources: &'a Sources<'a>,
    path: &'a Path,
    /// `None` for a buffer that no view needs as it is.
    bytes: Vec<Option<Cow<'a, [u8]>>>,
    /// The views that were compressed, decoded when they were first used.
    #[cfg(feature = "meshopt")]
    decoded: Vec<std::cell::OnceCell<Vec<u8>>>,
}

impl<'a> Buffers<'a> {
    /// Reads the buffers that are not in the file itself, without those that only stand in for compressed views.
    pub(super) fn load(
        sources: &'a Sources<'a>,
        root: &Root,
        mut bin: Option<Cow<'a, [u8]>>,
    ) -> Result<Self> {
        let path = sources.scene;
        let needed = needed_buffers(root);
        let mut bytes = Vec::with_capacity(root.buffers.len());
        for (index, buffer) in root.buffers.iter().enumerate() {
            let stated = buffer.byte_length.0;
            let bin = if index == 0 && buffer.uri.is_none() { bin.take() } else { None };
            if !needed[index] {
                bytes.push(None);
                continue;
            }
            let data = match (&buffer.uri, bin) {
                (Some(uri), _) => Cow::Owned(read_uri(sources, uri, &format!("buffer {index}"), stated)?),
                (None, Some(bin)) => bin,
                (None, None) if is_fallback(buffer) => {
                    bytes.push(None);
                    continue;
                }
                (None, None) => Cow::default(),
            };
            if (data.len() as u64) < stated {
                return Err(bad(path, format!("buffer {index} has {} bytes, not {stated}", data.len())));
            }
            bytes.push(Some(data));
        }
        Ok(Self {
            sources,
            path,
            bytes,
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
        #[cfg(feature = "meshopt")]
        if let Some((extension, json)) = compression(view) {
            return Ok((self.decode(index, view, extension, json)?, view));
        }
        let buffer = view.buffer.value();
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
        let bytes = self
            .slice(compressed.buffer, compressed.byte_offset, compressed.byte_length)
            .ok_or_else(|| broken(format!("its {extension} reaches past its buffer")))?;
        let size = compressed.decoded_bytes();
        self.sources.budget.charge(size, || format!("the decoded buffer view {index}"))?;
        let decoded = compressed.decode(bytes).map_err(broken)?;
        Ok(cell.get_or_init(|| decoded))
    }

    fn slice(&self, buffer: usize, from: u64, length: u64) -> Option<&[u8]> {
        let to = from.checked_add(length)?;
        let range = usize::try_from(from).ok()?..usize::try_from(to).ok()?;
        self.bytes.get(buffer)?.as_ref()?.get(range)
    }
}

/// For each buffer, whether a view needs it. The buffer of a view that is decoded is not needed by it.
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

/// Whether a buffer only stands in for compressed data, so that it need not exist.
fn is_fallback(buffer: &buffer::Buffer) -> bool {
    buffer.extensions.as_ref().is_some_and(|e| meshopt::is_fallback(&e.others))
}

/// An [`Error::SceneParse`] for a glTF file.
pub(super) fn bad(path: &Path, what: impl Into<String>) -> Error {
    Error::SceneParse { path: path.to_owned(), format: "glTF", what: what.into() }
}

/// Reads a data URI, or the first `max_bytes` bytes of a file next to the scene; `place` is the part of the scene that
/// references it.
fn read_uri(sources: &Sources<'_>, uri: &str, place: &str, max_bytes: u64) -> Result<Vec<u8>> {
    match uri.strip_prefix("data:") {
        Some(data) => read_data(sources, data, place),
        None => sources.read_start(&sources.locate(place, &file_name(uri))?, place, max_bytes),
    }
}

/// Decodes a data URI, given without its `data:` prefix.
pub(super) fn read_data(sources: &Sources<'_>, data: &str, place: &str) -> Result<Vec<u8>> {
    sources.budget.charge(data.len() as u64, || format!("the data URI of {place}"))?;
    let decoded = data.split_once(',').and_then(|(kind, body)| {
        if kind.ends_with(";base64") { decode_base64(body) } else { Some(decode_percent(body)) }
    });
    decoded.ok_or_else(|| bad(sources.scene, format!("the data URI of {place} is not valid base64")))
}

/// The file name in a relative URI, with percent-encoding decoded.
pub(super) fn file_name(uri: &str) -> String {
    String::from_utf8_lossy(&decode_percent(uri)).into_owned()
}

fn decode_percent(text: &str) -> Vec<u8> {
    let digit = |b: Option<&u8>| b.and_then(|&b| char::from(b).to_digit(16));
    let bytes = text.as_bytes();
    let (mut out, mut at) = (Vec::with_capacity(bytes.len()), 0);
    while let Some(&byte) = bytes.get(at) {
        match (byte, digit(bytes.get(at + 1)), digit(bytes.get(at + 2))) {
            (b'%', Some(high), Some(low)) => {
                out.push((high * 16 + low) as u8);
                at += 3;
            }
            _ => {
                out.push(byte);
                at += 1;
            }
        }
    }
    out
}

fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut count) = (0_u32, 0);
    for byte in text.bytes() {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => break,
            b if b.is_ascii_whitespace() => continue,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        count += 6;
        if count >= 8 {
            count -= 8;
            out.push((bits >> count) as u8);
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uri_decodes_base64_and_percent() {
        assert_eq!(decode_base64("aGVsbG8=").as_deref(), Some(&b"hello"[..]));
        assert_eq!(decode_base64("aGVs\nbG8").as_deref(), Some(&b"hello"[..]));
        assert_eq!(decode_base64("a*"), None);
        assert_eq!(decode_percent("a%20b%zz%4"), b"a b%zz%4");
    }
}
