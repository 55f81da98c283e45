//! The bytes of a glTF scene: the GLB container, buffers in files and in data URIs, and views into them.

use std::borrow::Cow;
use std::path::Path;

use ::gltf::binary::Glb;
use ::gltf::json::{Root, buffer};

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
    bytes: Vec<Cow<'a, [u8]>>,
}

impl<'a> Buffers<'a> {
    /// Reads the buffers that are not in the file itself.
    pub(super) fn load(
        sources: &'a Sources<'a>,
        root: &Root,
        mut bin: Option<Cow<'a, [u8]>>,
    ) -> Result<Self> {
        let path = sources.scene;
        let mut bytes = Vec::with_capacity(root.buffers.len());
        for (index, buffer) in root.buffers.iter().enumerate() {
            let stated = buffer.byte_length.0;
            let data = match (&buffer.uri, index) {
                (Some(uri), _) => Cow::Owned(read_uri(sources, uri, &format!("buffer {index}"), stated)?),
                (None, 0) => bin.take().unwrap_or_default(),
                (None, _) => Cow::default(),
            };
            if (data.len() as u64) < stated {
                return Err(bad(path, format!("buffer {index} has {} bytes, not {stated}", data.len())));
            }
            bytes.push(data);
        }
        Ok(Self { sources, path, bytes })
    }

    /// Total size of all buffers, bytes: an upper bound on the data that the file can describe.
    pub(super) fn total(&self) -> u64 {
        self.bytes.iter().map(|b| b.len() as u64).sum()
    }

    /// The bytes of a buffer view.
    pub(super) fn view<'s>(&'s self, root: &'s Root, index: usize) -> Result<(&'s [u8], &'s buffer::View)> {
        let Some(view) = root.buffer_views.get(index) else {
            return Err(bad(self.path, format!("buffer view {index} does not exist")));
        };
        let from = view.byte_offset.map_or(0, |o| o.0);
        let range = from
            .checked_add(view.byte_length.0)
            .and_then(|to| Some(usize::try_from(from).ok()?..usize::try_from(to).ok()?));
        let buffer = self.bytes.get(view.buffer.value());
        match buffer.zip(range).and_then(|(b, r)| b.get(r)) {
            Some(bytes) => Ok((bytes, view)),
            None => Err(bad(self.path, format!("buffer view {index} reaches past its buffer"))),
        }
    }
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
