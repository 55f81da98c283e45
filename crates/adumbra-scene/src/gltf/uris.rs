//! URIs of glTF files (glTF 2.0, 2.8): data URIs with base64 or percent-encoding, and relative names of
//! files.
//!
//! The specification requires percent-encoded names with slashes. Names that are not encoded, or that have
//! backslashes, are common. A file is therefore looked for first under its decoded name, then under the name
//! as written.

use crate::error::{Error, Result};
use crate::gltf::faults::bad;
use crate::sources::{Located, Sources};

/// Reads a data URI, or the first `max_bytes` bytes of a file next to the scene; `place` is the part of the
/// scene that references it.
pub(super) fn read(sources: &Sources<'_>, uri: &str, place: &str, max_bytes: u64) -> Result<Vec<u8>> {
    match uri.strip_prefix("data:") {
        Some(data) => read_data(sources, data, place),
        None => sources.read_start(&locate(sources, place, uri)?, place, max_bytes),
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

/// The names under which to look for the file of a relative URI. The decoded name comes first.
pub(super) fn names(uri: &str) -> Vec<String> {
    let decoded = String::from_utf8_lossy(&decode_percent(uri)).into_owned();
    let mut names = vec![decoded];
    let others = [uri.to_owned(), names[0].replace('\\', "/"), uri.replace('\\', "/")];
    for name in others {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// Finds the file of a relative URI; `place` is the part of the scene that references it.
///
/// # Errors
/// Returns [`Error::OutsideScene`] if one of its names is outside the folder, otherwise the error of the
/// first name; or [`Error::SceneMemory`].
pub(super) fn locate(sources: &Sources<'_>, place: &str, uri: &str) -> Result<Located> {
    let mut names = names(uri).into_iter();
    let mut error = match sources.locate(place, names.next().as_deref().unwrap_or_default()) {
        Ok(file) => return Ok(file),
        Err(error) => error,
    };
    for name in names {
        match sources.locate(place, &name) {
            Ok(file) => {
                sources.note_named(&name)?;
                return Ok(file);
            }
            Err(outside @ Error::OutsideScene { .. }) => error = outside,
            Err(_) => {}
        }
    }
    Err(error)
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

    #[test]
    fn uri_names_are_decoded_first_then_as_written() {
        assert_eq!(names("a%20b.bin"), ["a b.bin", "a%20b.bin"]);
        assert_eq!(names("t\\100%.bin"), ["t\\100%.bin", "t/100%.bin"]);
        assert_eq!(names("a.bin"), ["a.bin"]);
    }
}
