//! The text of OBJ and MTL files: encodings, lines, statements, words and numbers.
//!
//! Text is handled as bytes, because neither format states an encoding: names are compared byte by byte, and
//! shown as UTF-8 or else as Latin-1. A line ends in LF, CR or both. A `#` at the beginning of a word begins
//! a comment, which ends with its line; one inside a word belongs to the word. A backslash at the end of a
//! line joins it to the next, unless the line ends in a comment. NUL bytes count as white space.

use std::borrow::Cow;

use crate::Result;
use crate::budget::Budget;

/// Removes a byte-order mark, and converts UTF-16 to UTF-8. Text whose first two characters each have a NUL
/// byte before or after them is UTF-16 without a mark. The inner error is a clause for a message. The budget
/// already holds the bytes.
///
/// # Errors
/// Returns [`crate::Error::SceneMemory`] if the converted text exceeds the budget.
pub(super) fn decoded(mut bytes: Vec<u8>, budget: &Budget<'_>) -> Result<Result<Vec<u8>, &'static str>> {
    let (little, start) = match bytes.as_slice() {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => {
            return Ok(Err("its text is UTF-32, which is not read; save it as UTF-8"));
        }
        [0xef, 0xbb, 0xbf, ..] => {
            bytes.drain(..3);
            return Ok(Ok(bytes));
        }
        [0xff, 0xfe, ..] => (true, 2),
        [0xfe, 0xff, ..] => (false, 2),
        &[a, 0, b, 0, ..] if a != 0 && b != 0 => (true, 0),
        &[0, a, 0, b, ..] if a != 0 && b != 0 => (false, 0),
        _ => return Ok(Ok(bytes)),
    };
    let (units, _) = bytes.get(start..).unwrap_or_default().as_chunks::<2>();
    // A unit of two bytes becomes at most three.
    let room = units.len() * 3;
    budget.charge(room as u64, || "the text".to_owned())?;
    let mut text = String::with_capacity(room);
    let units = units.iter().map(|&u| if little { u16::from_le_bytes(u) } else { u16::from_be_bytes(u) });
    text.extend(char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)));
    text.shrink_to_fit();
    budget.release((room - text.len() + bytes.len()) as u64);
    Ok(Ok(text.into_bytes()))
}

/// Reads the statements of a text one by one.
pub(super) struct Statements<'t> {
    text: &'t [u8],
    /// Lines read so far.
    lines: usize,
    /// The current statement if it continues over several lines. It is never longer than the text.
    joined: Vec<u8>,
}

/// One statement: a keyword and the text after it.
#[derive(Clone, Copy)]
pub(super) struct Statement<'s> {
    /// Its first line, counted from 1.
    pub(super) line: usize,
    /// Its first word; empty if the joined lines are blank.
    pub(super) keyword: &'s [u8],
    /// The text after the keyword, without surrounding white space and without a comment.
    pub(super) rest: &'s [u8],
    /// The text after the keyword, with the comment.
    pub(super) whole: &'s [u8],
}

impl<'t> Statements<'t> {
    pub(super) fn of(text: &'t [u8]) -> Self {
        Self { text, lines: 0, joined: Vec::new() }
    }

    /// The next statement; lines without one are skipped.
    pub(super) fn next(&mut self) -> Option<Statement<'_>> {
        let (first, start) = loop {
            let line = trim(self.next_line()?);
            let code = without_comment(line);
            if !code.is_empty() {
                break (line, code);
            }
        };
        let line = self.lines;
        if start.len() < first.len() || !start.ends_with(b"\\") {
            return Some(Statement::new(line, first));
        }
        self.joined.clear();
        self.joined.extend_from_slice(start);
        self.joined.pop();
        while let Some(next) = self.next_line() {
            let next = trim(next);
            self.joined.push(b' ');
            self.joined.extend_from_slice(next);
            if without_comment(next).len() < next.len() || !next.ends_with(b"\\") {
                break;
            }
            self.joined.pop();
        }
        Some(Statement::new(line, trim(&self.joined)))
    }

    fn next_line(&mut self) -> Option<&'t [u8]> {
        if self.text.is_empty() {
            return None;
        }
        self.lines += 1;
        let end = self.text.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(self.text.len());
        let (line, rest) = self.text.split_at(end);
        self.text = match rest {
            [b'\r', b'\n', rest @ ..] | [_, rest @ ..] => rest,
            [] => rest,
        };
        Some(line)
    }
}

impl<'s> Statement<'s> {
    fn new(line: usize, whole: &'s [u8]) -> Self {
        let code = without_comment(whole);
        let end = code.iter().position(is_space).unwrap_or(code.len());
        let (keyword, rest) = code.split_at(end);
        Self { line, keyword, rest: trim(rest), whole: trim(whole.get(end..).unwrap_or_default()) }
    }

    /// The name that the statement states.
    pub(super) fn name(&self) -> Name {
        Name { short: unquoted(self.rest).to_owned(), long: unquoted(self.whole).to_owned() }
    }
}

/// A name that a statement states up to the end of its line. It is ambiguous if it holds a word that begins
/// with `#`: `usemtl wood # oak` has a comment, `usemtl Material #25` has none.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Name {
    /// Without the comment.
    pub(super) short: Vec<u8>,
    /// Including the comment.
    pub(super) long: Vec<u8>,
}

/// The keyword in lower case, in `buffer`; empty if it is longer than any keyword.
pub(super) fn lower<'b>(keyword: &[u8], buffer: &'b mut [u8; 16]) -> &'b [u8] {
    let Some(lower) = buffer.get_mut(..keyword.len()) else { return &[] };
    lower.copy_from_slice(keyword);
    lower.make_ascii_lowercase();
    lower
}

/// The words of a text.
pub(super) fn words(text: &[u8]) -> impl DoubleEndedIterator<Item = &[u8]> + Clone {
    text.split(is_space).filter(|word| !word.is_empty())
}

/// Parses a number as programs write it. Any spelling that means NaN, such as `-nan(ind)` and `1.#QNAN`,
/// gives NaN. A comment may follow without white space.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    let unsigned = text.trim_start_matches(['-', '+']).to_ascii_lowercase();
    if ["nan", "1.#", "1,#"].iter().any(|start| unsigned.starts_with(start)) {
        return Some(f64::NAN);
    }
    text.split_once('#')?.0.parse().ok()
}

/// The first `N` words as numbers.
pub(super) fn numbers<const N: usize>(text: &[u8]) -> Option<[f64; N]> {
    let mut words = words(text);
    let mut out = [0.0; N];
    for value in &mut out {
        *value = number(words.next()?)?;
    }
    Some(out)
}

/// The text for messages and filters: as UTF-8, or else as Latin-1, which gives every byte a character.
pub(super) fn shown(text: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(text) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(text.iter().map(|&b| char::from(b)).collect()),
    }
}

/// The text without white space around it.
pub(super) fn trim(mut text: &[u8]) -> &[u8] {
    while let [first, rest @ ..] = text
        && is_space(first)
    {
        text = rest;
    }
    while let [rest @ .., last] = text
        && is_space(last)
    {
        text = rest;
    }
    text
}

/// The text without the pair of quotes around it.
pub(super) fn unquoted(text: &[u8]) -> &[u8] {
    match text {
        [b'"', inside @ .., b'"'] if !inside.contains(&b'"') => trim(inside),
        _ => text,
    }
}

/// The start of a line up to its comment, without trailing white space.
fn without_comment(line: &[u8]) -> &[u8] {
    let mut from = 0;
    while let Some(at) = line.get(from..).and_then(|rest| rest.iter().position(|&b| b == b'#')) {
        let (before, _) = line.split_at(from + at);
        if before.last().is_none_or(is_space) {
            return trim(before);
        }
        from += at + 1;
    }
    line
}

fn is_space(byte: &u8) -> bool {
    matches!(byte, b' ' | b'\t' | 0x0b | 0x0c | 0)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn statements(text: &[u8]) -> Vec<(usize, String, String)> {
        let mut statements = Statements::of(text);
        let mut out = Vec::new();
        while let Some(s) = statements.next() {
            out.push((s.line, shown(s.keyword).into_owned(), shown(s.rest).into_owned()));
        }
        out
    }

    #[test]
    fn splits_lines_of_all_kinds_into_statements() {
        let is = |text: &str, expected: &[(usize, &str, &str)]| {
            let expected: Vec<_> =
                expected.iter().map(|&(l, k, r)| (l, k.to_owned(), r.to_owned())).collect();
            assert_eq!(statements(text.as_bytes()), expected, "{text:?}");
        };
        is("v 1\r\nv 2\rv 3\n\nv 4", &[(1, "v", "1"), (2, "v", "2"), (3, "v", "3"), (5, "v", "4")]);
        is("# C:\\models\\\nv 1", &[(2, "v", "1")]);
        is("v 1 # a\\\nv 2", &[(1, "v", "1"), (2, "v", "2")]);
        is("f 1 \\ \n\t2\\\r\n3\nv 1", &[(1, "f", "1  2 3"), (4, "v", "1")]);
        is("f 1 \\\n# 2\n3", &[(1, "f", "1"), (3, "3", "")]);
        is("f 1 \\", &[(1, "f", "1")]);
        is("usemtl wood#2\t \n\t usemtl\twood #2", &[(1, "usemtl", "wood#2"), (2, "usemtl", "wood")]);
        is("v 1\0\0\n\0\n#\n  #\n#\\\n\\\n\n", &[(1, "v", "1"), (6, "", "")]);
    }

    #[test]
    fn parses_numbers_as_programs_write_them() {
        for nan in ["nan", "NaN", "-nan(ind)", "1.#IND", "-1.#IND00", "1.#QNAN", "+1.#INF", "-nan"] {
            assert!(number(nan.as_bytes()).is_some_and(f64::is_nan), "{nan}");
        }
        for (text, value) in [("1", 1.0), ("+1.5e1", 15.0), (".5", 0.5), ("5.", 5.0), ("3#c", 3.0)] {
            assert_eq!(number(text.as_bytes()), Some(value), "{text}");
        }
        for text in ["", "x", "1,5", "#", "0x1", "na"] {
            assert_eq!(number(text.as_bytes()), None, "{text}");
        }
        assert_eq!(number(b"inf"), Some(f64::INFINITY));
    }

    #[test]
    fn detects_encodings_with_and_without_marks() {
        let budget = Budget::new(Path::new("scene.obj"), None);
        let text = "v 1 # \u{e9}\u{1f333}\n";
        let units: Vec<u16> = text.encode_utf16().collect();
        let (little, big): (Vec<u8>, Vec<u8>) = (
            units.iter().flat_map(|u| u.to_le_bytes()).collect(),
            units.iter().flat_map(|u| u.to_be_bytes()).collect(),
        );
        let marked = |mark: &[u8], text: &[u8]| [mark, text].concat();
        let cases = [
            text.as_bytes().to_vec(),
            marked(&[0xef, 0xbb, 0xbf], text.as_bytes()),
            marked(&[0xff, 0xfe], &little),
            marked(&[0xfe, 0xff], &big),
            little,
            big,
        ];
        for bytes in cases {
            let decoded = decoded(bytes, &budget).expect("fits").expect("known");
            assert_eq!(String::from_utf8(decoded).as_deref(), Ok(text));
        }
        for wide in [[0xff, 0xfe, 0, 0], [0, 0, 0xfe, 0xff]] {
            let error = decoded(wide.to_vec(), &budget).expect("fits").expect_err("not read");
            assert!(error.contains("UTF-32"));
        }
        assert_eq!(shown(b"caf\xe9"), "caf\u{e9}");
    }
}
