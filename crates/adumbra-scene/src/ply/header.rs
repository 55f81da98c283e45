//! The header of a PLY file: its keywords, types and elements (Greg Turk, *The PLY Polygon File Format*,
//! 1994, with the reserved words of his reader).
//!
//! Extensions of that text that common files need: a byte-order mark, blank lines, several blanks between
//! words, `comment` and `obj_info` anywhere and in any encoding, and the types with stated sizes (`int8` …
//! `float64`). The line end of the first line, LF, CRLF or CR, applies to the whole header.

use crate::Result;
use crate::sources::Sources;

/// Maximum number of elements in a header. Real files have fewer than ten.
const MAX_ELEMENTS: usize = 1000;
/// Names are shown in messages up to this many characters.
const SHOWN_CHARS: usize = 40;
/// Memory that a property and the steps that read it take while they are listed, bytes.
const PROPERTY_BYTES: u64 = 128;

/// How the records are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a scalar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    fn named(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"int64" => Self::I64,
            b"uint64" => Self::U64,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Size in a binary file, bytes.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// One property of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Property<'a> {
    pub(super) name: &'a [u8],
    /// The type of a list's number of items; none for a scalar.
    pub(super) list: Option<Kind>,
    /// The type of the scalar, or of a list's items.
    pub(super) kind: Kind,
}

/// A number of records with the same properties.
#[derive(Debug)]
pub(super) struct Element<'a> {
    pub(super) name: &'a [u8],
    /// Number of records.
    pub(super) count: u64,
    pub(super) properties: Vec<Property<'a>>,
}

/// The parsed header.
#[derive(Debug)]
pub(super) struct Header<'a> {
    pub(super) format: Format,
    pub(super) elements: Vec<Element<'a>>,
    /// Where the records begin, bytes from the file's start.
    pub(super) body: usize,
}

/// A name or a word of the file as messages show it: UTF-8 or Latin-1, shortened, without control characters.
pub(super) fn shown(word: &[u8]) -> String {
    let word = word.get(..4 * SHOWN_CHARS).unwrap_or(word);
    let text = match std::str::from_utf8(word) {
        Ok(text) => text.to_owned(),
        Err(_) => word.iter().map(|&byte| char::from(byte)).collect(),
    };
    let mut out: String = text.chars().take(SHOWN_CHARS).flat_map(char::escape_debug).collect();
    if text.chars().nth(SHOWN_CHARS).is_some() {
        out.push('…');
    }
    out
}

impl<'a> Header<'a> {
    /// Reads the header.
    ///
    /// # Errors
    /// Returns [`Error::SceneParse`](crate::Error::SceneParse) with the line, or
    /// [`Error::SceneMemory`](crate::Error::SceneMemory).
    pub(super) fn parse(sources: &Sources<'_>, bytes: &'a [u8]) -> Result<Self> {
        let mut lines = Lines::new(bytes);
        let (mut format, mut elements) = (None, Vec::<Element<'a>>::new());
        let starts = lines.find(|words| !words.is_empty()).is_some_and(|words| words == [b"ply"]);
        if !starts {
            return Err(sources.bad("it does not begin with a line \"ply\""));
        }
        loop {
            let Some(words) = lines.next() else {
                return Err(sources.bad("its header has no line \"end_header\""));
            };
            let number = lines.number;
            let bad = |what: String| sources.bad(format!("{what} (line {number}, in the header)"));
            match words.as_slice() {
                [] | [b"comment" | b"obj_info", ..] => {}
                [b"end_header"] => break,
                [b"format", rest @ ..] => {
                    if format.is_some() {
                        return Err(bad("it states its format twice".to_owned()));
                    }
                    format = Some(stated_format(rest).map_err(bad)?);
                }
                [b"element", rest @ ..] => {
                    if elements.len() == MAX_ELEMENTS {
                        return Err(bad(format!("it has more than {MAX_ELEMENTS} elements")));
                    }
                    elements.push(stated_element(rest).map_err(bad)?);
                }
                [b"property", rest @ ..] => {
                    let Some(element) = elements.last_mut() else {
                        return Err(bad("a property is stated before any element".to_owned()));
                    };
                    sources.budget.charge(PROPERTY_BYTES, || "the properties of its header".to_owned())?;
                    element.properties.push(stated_property(rest).map_err(bad)?);
                }
                [keyword, ..] => {
                    let what = format!("\"{}\" is no keyword of a PLY header", shown(keyword));
                    return Err(bad(what));
                }
            }
        }
        let Some(format) = format else {
            return Err(sources.bad("its header has no line \"format\""));
        };
        Ok(Self { format, elements, body: lines.at })
    }
}

fn stated_format(words: &[&[u8]]) -> Result<Format, String> {
    let format = match words.first() {
        Some(&b"ascii") => Format::Ascii,
        Some(&b"binary_little_endian") => Format::LittleEndian,
        Some(&b"binary_big_endian") => Format::BigEndian,
        Some(other) => {
            let known = "ascii, binary_little_endian and binary_big_endian";
            return Err(format!("there is no format \"{}\", but {known}", shown(other)));
        }
        None => return Err("it names no format".to_owned()),
    };
    match words.get(1) {
        None | Some(&(b"1.0" | b"1")) => Ok(format),
        Some(version) => Err(format!("there is no version \"{}\" of the format, only 1.0", shown(version))),
    }
}

fn stated_element<'a>(words: &[&'a [u8]]) -> Result<Element<'a>, String> {
    let [name, count, ..] = words else {
        return Err("an element needs a name and a number of records".to_owned());
    };
    let number = std::str::from_utf8(count).ok().and_then(|text| text.parse().ok());
    let Some(count) = number else {
        let [name, count] = [name, count].map(|word| shown(word));
        return Err(format!("element \"{name}\" has \"{count}\" records, which is no possible number"));
    };
    Ok(Element { name, count, properties: Vec::new() })
}

fn stated_property<'a>(words: &[&'a [u8]]) -> Result<Property<'a>, String> {
    let kind = |word: &[u8]| {
        Kind::named(word).ok_or_else(|| format!("there is no property type \"{}\"", shown(word)))
    };
    match *words {
        [b"list", count, item, name, ..] => {
            Ok(Property { name, list: Some(kind(count)?), kind: kind(item)? })
        }
        [b"list", ..] => Err("a list needs a type for its length, one for its items, and a name".to_owned()),
        [scalar, name, ..] => Ok(Property { name, list: None, kind: kind(scalar)? }),
        _ => Err("a property needs a type and a name".to_owned()),
    }
}

/// The lines of the header, split into words.
struct Lines<'a> {
    bytes: &'a [u8],
    /// Where the next line begins.
    at: usize,
    /// The number of the last line, from 1.
    number: usize,
    /// The last byte of each line end.
    end: u8,
}

impl<'a> Lines<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        let at = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let first = bytes.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let ends_in_cr = first.is_some_and(|i| bytes[i] == b'\r' && bytes.get(i + 1) != Some(&b'\n'));
        Self { bytes, at, number: 0, end: if ends_in_cr { b'\r' } else { b'\n' } }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Vec<&'a [u8]>;

    /// Returns up to five words of the next line. No statement that is read has more.
    fn next(&mut self) -> Option<Self::Item> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|&b| b == self.end).unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        self.number += 1;
        let words = rest[..length].split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        Some(words.take(5).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shown_words_are_shortened_and_escaped() {
        assert_eq!(shown(b"vertex_indices"), "vertex_indices");
        assert_eq!(shown("größe".as_bytes()), "größe");
        assert_eq!(shown(b"gr\xf6\xdfe"), "größe");
        assert_eq!(shown(b"a\x1bb"), "a\\u{1b}b");
        assert_eq!(shown(&[b'x'; 500]).chars().count(), 41);
    }

    #[test]
    fn first_line_end_applies_to_the_whole_header() {
        let bodies = |bytes: &[u8]| {
            let mut lines = Lines::new(bytes);
            lines.find(|words| words == &[b"end_header"]).expect("is there");
            bytes[lines.at..].to_vec()
        };
        assert_eq!(bodies(b"ply\nend_header\n\r\n"), b"\r\n");
        assert_eq!(bodies(b"ply\r\nend_header \r\n\n"), b"\n");
        assert_eq!(bodies(b"ply\rend_header\r\n\r"), b"\n\r");
        assert_eq!(bodies(b"\xef\xbb\xbfply\n\nend_header"), b"");
    }
}
