//! The values of a PLY file's records, one after another: words of text, or numbers of stated sizes in either
//! byte order.
//!
//! Text is a sequence of words: records may run over several lines or share one. Any byte up to the space
//! separates them.

use super::header::{Kind, shown};

/// Why a value cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// The file ends before the value does.
    End,
    /// The value does not fit its property. Both texts are worded for a message.
    Unfit { found: String, wanted: &'static str },
}

/// Reads the values of a file's records, one after another.
pub(super) trait Values {
    /// Number of bytes that are left.
    fn left(&self) -> usize;

    /// The fewest bytes that a value of this type takes, including its separator in text.
    fn least(kind: Kind) -> usize;

    /// Skips `count` values of type `kind`, whatever they are.
    fn skip(&mut self, count: usize, kind: Kind) -> Result<(), Fault>;

    /// The next value.
    fn number(&mut self, kind: Kind) -> Result<f64, Fault>;

    /// The next value as a whole number; one out of range becomes the nearest of an `i64`.
    fn whole(&mut self, kind: Kind) -> Result<i64, Fault>;

    /// The line of the last value, counted from 1; `None` in a binary file.
    fn line(&self) -> Option<usize>;

    /// Number of values from here to the end, or 0 if it is unknown.
    fn count_rest(&mut self) -> u64;
}

/// Whole numbers, of any type.
const WHOLE: &str = "a whole number";

fn whole_of(number: f64, found: impl FnOnce() -> String) -> Result<i64, Fault> {
    if number.is_finite() && number.fract() == 0.0 {
        return Ok(number as i64);
    }
    Err(Fault::Unfit { found: found(), wanted: WHOLE })
}

/// Values as words.
pub(super) struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Where the last word begins.
    last: usize,
}

impl<'a> Text<'a> {
    /// The values of a whole file from byte `at` on.
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, last: at }
    }

    fn word(&mut self) -> Result<&'a [u8], Fault> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let blanks = rest.iter().position(|&b| b > b' ').ok_or(Fault::End)?;
        let rest = &rest[blanks..];
        let length = rest.iter().position(|&b| b <= b' ').unwrap_or(rest.len());
        self.last = self.at + blanks;
        self.at = self.last + length;
        Ok(&rest[..length])
    }
}

impl Values for Text<'_> {
    fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    fn least(_: Kind) -> usize {
        2
    }

    fn skip(&mut self, count: usize, _: Kind) -> Result<(), Fault> {
        (0..count).try_for_each(|_| self.word().map(|_| ()))
    }

    fn number(&mut self, _: Kind) -> Result<f64, Fault> {
        let word = self.word()?;
        number_of(word).ok_or_else(|| Fault::Unfit { found: shown(word), wanted: "a number" })
    }

    fn whole(&mut self, _: Kind) -> Result<i64, Fault> {
        let word = self.word()?;
        if let Some(whole) = digits_of(word) {
            return Ok(whole);
        }
        whole_of(number_of(word).unwrap_or(f64::NAN), || shown(word))
    }

    fn line(&self) -> Option<usize> {
        let before = self.bytes.get(..self.last).unwrap_or(self.bytes);
        let line_ends = before.iter().zip(before.iter().skip(1).chain([&0]));
        Some(1 + line_ends.filter(|&(&a, &b)| a == b'\n' || a == b'\r' && b != b'\n').count())
    }

    fn count_rest(&mut self) -> u64 {
        (0..).take_while(|_| self.word().is_ok()).count() as u64
    }
}

/// A whole number of up to 18 digits.
fn digits_of(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        _ => (false, word),
    };
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut whole = 0_i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        whole = whole * 10 + i64::from(digit - b'0');
    }
    Some(if negative { -whole } else { whole })
}

/// Parses a number, including non-finite values as C libraries print them: `nan(ind)`, `-1.#IND`,
/// `1.#QNAN`, `1.#INF00`.
fn number_of(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(number) = text.parse() {
        return Some(number);
    }
    let unsigned = word.strip_prefix(b"-").or_else(|| word.strip_prefix(b"+")).unwrap_or(word);
    let starts = |with: &[u8]| unsigned.get(..with.len()).is_some_and(|s| s.eq_ignore_ascii_case(with));
    if starts(b"1.#inf") {
        let infinite = f64::INFINITY;
        return Some(if word.starts_with(b"-") { -infinite } else { infinite });
    }
    (starts(b"nan") || starts(b"1.#")).then_some(f64::NAN)
}

/// Values in a binary file; `BIG` means big-endian.
pub(super) struct Binary<'a, const BIG: bool> {
    rest: &'a [u8],
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    pub(super) fn new(body: &'a [u8]) -> Self {
        Self { rest: body }
    }

    /// The next `N` bytes, converted to little-endian order.
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let (&bytes, rest) = self.rest.split_first_chunk::<N>().ok_or(Fault::End)?;
        self.rest = rest;
        let mut bytes = bytes;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> Values for Binary<'_, BIG> {
    fn left(&self) -> usize {
        self.rest.len()
    }

    fn least(kind: Kind) -> usize {
        kind.bytes()
    }

    fn skip(&mut self, count: usize, kind: Kind) -> Result<(), Fault> {
        let bytes = count.checked_mul(kind.bytes()).ok_or(Fault::End)?;
        self.rest = self.rest.get(bytes..).ok_or(Fault::End)?;
        Ok(())
    }

    fn number(&mut self, kind: Kind) -> Result<f64, Fault> {
        match kind {
            Kind::F32 => Ok(f64::from(f32::from_le_bytes(self.take()?))),
            Kind::F64 => Ok(f64::from_le_bytes(self.take()?)),
            Kind::U64 => Ok(u64::from_le_bytes(self.take()?) as f64),
            _ => Ok(self.whole(kind)? as f64),
        }
    }

    fn whole(&mut self, kind: Kind) -> Result<i64, Fault> {
        Ok(match kind {
            Kind::I8 => i64::from(i8::from_le_bytes(self.take()?)),
            Kind::U8 => i64::from(u8::from_le_bytes(self.take()?)),
            Kind::I16 => i64::from(i16::from_le_bytes(self.take()?)),
            Kind::U16 => i64::from(u16::from_le_bytes(self.take()?)),
            Kind::I32 => i64::from(i32::from_le_bytes(self.take()?)),
            Kind::U32 => i64::from(u32::from_le_bytes(self.take()?)),
            Kind::I64 => i64::from_le_bytes(self.take()?),
            Kind::U64 => i64::try_from(u64::from_le_bytes(self.take()?)).unwrap_or(i64::MAX),
            Kind::F32 | Kind::F64 => {
                let number = self.number(kind)?;
                return whole_of(number, || number.to_string());
            }
        })
    }

    fn line(&self) -> Option<usize> {
        None
    }

    /// Bytes after the last record have no type, so they cannot be counted as values.
    fn count_rest(&mut self) -> u64 {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_numbers_as_programs_write_them() {
        let number = |text: &str| number_of(text.as_bytes());
        for (text, value) in
            [("1", 1.0), ("-.5", -0.5), ("+5.", 5.0), ("1E3", 1000.0), ("0.1", 0.1), ("-0", 0.0)]
        {
            assert_eq!(number(text), Some(value), "{text}");
        }
        let infinite = [
            ("inf", 1.0),
            ("-Infinity", -1.0),
            ("1.#INF", 1.0),
            ("-1.#INF00", -1.0),
            ("+1.#inf", 1.0),
            ("1e999", 1.0),
        ];
        for (text, sign) in infinite {
            assert_eq!(number(text), Some(sign * f64::INFINITY), "{text}");
        }
        for text in [
            "nan",
            "-nan",
            "NaN",
            "nan(ind)",
            "-nan(snan)",
            "1.#IND",
            "-1.#IND",
            "1.#QNAN0",
            "1.#SNAN",
            "1.#J",
        ] {
            assert!(number(text).is_some_and(f64::is_nan), "{text}");
        }
        for text in ["", "-", "x", "1,5", "0x10", "--1", "1.5.", "in", "2.#IND"] {
            assert_eq!(number(text), None, "{text}");
        }
    }

    #[test]
    fn parses_whole_numbers_in_text() {
        let text = "7 -1 +3 3.0 1e2 99999999999999999999 -1e300 0.5 nan x";
        let mut values = Text::new(text.as_bytes(), 0);
        let mut next = || values.whole(Kind::U8);
        let found: Vec<_> = (0..7).map(|_| next().expect("is whole")).collect();
        assert_eq!(found, [7, -1, 3, 3, 100, i64::MAX, i64::MIN]);
        for word in ["0.5", "nan", "x"] {
            assert_eq!(next(), Err(Fault::Unfit { found: word.to_owned(), wanted: WHOLE }));
        }
        assert_eq!(next(), Err(Fault::End));
    }

    #[test]
    fn counts_lines_that_end_in_lf_crlf_or_cr() {
        for (text, line) in
            [("a\nb\n\nz", 4), ("a\r\nb\r\n\r\nz", 4), ("a\rb\r\rz", 4), ("z", 1), ("\tz\n", 1)]
        {
            let mut values = Text::new(text.as_bytes(), 0);
            while values.word().expect("z is there") != b"z" {}
            assert_eq!(values.line(), Some(line), "{text:?}");
        }
    }

    #[test]
    fn reads_numbers_of_every_type_and_byte_order() {
        let mut little = Vec::new();
        little.extend((-2_i8).to_le_bytes());
        little.extend(200_u8.to_le_bytes());
        little.extend((-300_i16).to_le_bytes());
        little.extend(60_000_u16.to_le_bytes());
        little.extend((-70_000_i32).to_le_bytes());
        little.extend(4_000_000_000_u32.to_le_bytes());
        little.extend((-5_000_000_000_i64).to_le_bytes());
        little.extend(u64::MAX.to_le_bytes());
        little.extend(1.5_f32.to_le_bytes());
        little.extend(0.1_f64.to_le_bytes());
        let kinds = [
            (Kind::I8, -2.0),
            (Kind::U8, 200.0),
            (Kind::I16, -300.0),
            (Kind::U16, 60_000.0),
            (Kind::I32, -70_000.0),
            (Kind::U32, 4e9),
            (Kind::I64, -5e9),
            (Kind::U64, u64::MAX as f64),
            (Kind::F32, 1.5),
            (Kind::F64, 0.1),
        ];
        let (mut big, mut at) = (Vec::new(), 0);
        for (kind, _) in kinds {
            big.extend(little[at..at + kind.bytes()].iter().rev());
            at += kind.bytes();
        }
        let (mut little, mut big) = (Binary::<false>::new(&little), Binary::<true>::new(&big));
        for (kind, value) in kinds {
            assert_eq!(little.number(kind), Ok(value), "{kind:?}");
            assert_eq!(big.number(kind), Ok(value), "{kind:?}");
        }
        assert_eq!((little.left(), little.number(Kind::U8)), (0, Err(Fault::End)));
        assert_eq!(Binary::<true>::new(&[0x80, 0]).whole(Kind::U16), Ok(0x8000));
        let half = 2.5_f32.to_le_bytes();
        let unfit = Fault::Unfit { found: "2.5".to_owned(), wanted: WHOLE };
        assert_eq!(Binary::<false>::new(&half).whole(Kind::F32), Err(unfit));
        assert_eq!(Binary::<false>::new(&[255; 8]).whole(Kind::U64), Ok(i64::MAX));
    }
}
