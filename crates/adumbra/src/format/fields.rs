//! Fields of a header, put and taken one behind the other, and the checks that all kinds of file share.

use serde::Deserialize;
use serde::de::value::{Error as ValueError, MapDeserializer};

use super::FormatError;
use super::sections::Section;
use crate::light::{Sun, dot};
use crate::scene::Bounds;

/// How far axes may be from orthonormal and the sun from a unit vector: far above rounding, far below a texel.
pub(super) const UNIT_TOLERANCE: f64 = 1e-9;

/// Bytes of magic, version and header length, which every kind of file begins with.
const FRONT_BYTES: usize = 16;

/// One kind of file: what its first bytes say.
pub(super) struct Kind {
    pub(super) magic: [u8; 8],
    /// The magic as messages show it.
    pub(super) shown: &'static str,
    pub(super) name: &'static str,
    /// The version that is written, and the latest that is read.
    pub(super) version: u32,
    /// The earliest that is read.
    pub(super) oldest: u32,
}

/// The light-aligned graph.
pub(super) const LIGHT: Kind = Kind {
    magic: *b"ADUMBRA\n",
    shown: "\"ADUMBRA\\n\"",
    name: "light-aligned shadow file",
    version: 2,
    oldest: 1,
};
/// The world-aligned tree.
pub(super) const TREE: Kind =
    Kind { magic: *b"ADUMTREE", shown: "\"ADUMTREE\"", name: "tree file", version: 1, oldest: 1 };

/// Checks what makes the bytes a header of this kind: magic, version, length, checksum in the last word. Gives the
/// version and the fields between.
pub(super) fn identify<'a, const N: usize>(
    bytes: &'a [u8],
    kind: &Kind,
) -> Result<(u32, Decoder<'a>), FormatError> {
    let start = &bytes[..bytes.len().min(kind.magic.len())];
    if !kind.magic.starts_with(start) {
        return Err(match [LIGHT, TREE].iter().find(|other| other.magic == start) {
            Some(other) => FormatError::OtherKind { found: other.name, needed: kind.name },
            None => FormatError::Magic { found: start.to_vec(), expected: kind.shown },
        });
    }
    // A version that is not ours may have a shorter header, so it is looked at before the length.
    let mut fields = Decoder { bytes: bytes.get(kind.magic.len()..FRONT_BYTES).unwrap_or_default() };
    if let (Ok(version), Ok(length)) = (fields.u32(), fields.u32()) {
        if version > kind.version {
            return Err(FormatError::FutureVersion { version, supported: kind.version });
        }
        if version < kind.oldest {
            let range = format!("{} to {}", kind.oldest, kind.version);
            let expected = if kind.oldest == kind.version { kind.version.to_string() } else { range };
            return Err(field("version", version.to_string(), expected));
        }
        if length != N as u32 {
            return Err(field("header_bytes", length.to_string(), N.to_string()));
        }
    }
    let Some(header) = bytes.first_chunk::<N>() else {
        let (needed, have) = (N as u64, bytes.len() as u64);
        return Err(FormatError::Truncated { what: "header", needed, have });
    };
    let (covered, last) = header.split_at(N - 4);
    let computed = crc32fast::hash(covered);
    let stored = Decoder { bytes: last }.u32()?;
    if stored == computed {
        let version = Decoder { bytes: &covered[kind.magic.len()..] }.u32()?;
        Ok((version, Decoder { bytes: &covered[FRONT_BYTES..] }))
    } else {
        Err(FormatError::HeaderChecksum { stored, computed })
    }
}

/// The sun with exactly these bits: [`Sun::from_direction`] would normalise once more and change the last ones.
pub(super) fn sun(towards: [f64; 3]) -> Result<Sun, FormatError> {
    let unit = (dot(towards, towards) - 1.0).abs() <= UNIT_TOLERANCE;
    let entry = std::iter::once(("towards", towards.to_vec()));
    match Sun::deserialize(MapDeserializer::<_, ValueError>::new(entry)) {
        Ok(sun) if unit && towards[1] > 0.0 => Ok(sun),
        _ => Err(field("sun", format!("{towards:?}"), "a unit vector with y above zero")),
    }
}

/// The bounds that a flag says are there; without it all their bits are zero.
pub(super) fn bounds(there: bool, flag: &str, bounds: Bounds) -> Result<Option<Bounds>, FormatError> {
    if !there && bounds.min.iter().chain(&bounds.max).any(|c| c.to_bits() != 0) {
        let expected = format!("zero, as flag bit {flag} says that there are none");
        return Err(field("bounds", format!("{bounds:?}"), expected));
    }
    Ok(there.then_some(bounds))
}

pub(super) fn check_bounds(bounds: &Option<Bounds>) -> Result<(), FormatError> {
    if let Some(b) = bounds
        && !(0..3).all(|a| b.min[a].is_finite() && b.max[a].is_finite() && b.min[a] <= b.max[a])
    {
        return Err(field("bounds", format!("{b:?}"), "finite, the minimum not above the maximum"));
    }
    Ok(())
}

pub(super) fn check_voxel_size(size: f64) -> Result<(), FormatError> {
    if size.is_finite() && size > 0.0 {
        return Ok(());
    }
    Err(field("voxel_size", size.to_string(), "a finite number above zero"))
}

pub(super) fn check_finite(
    name: &'static str,
    values: &[f64],
    shown: impl std::fmt::Debug,
) -> Result<(), FormatError> {
    if values.iter().all(|v| v.is_finite()) {
        return Ok(());
    }
    Err(field(name, format!("{shown:?}"), "finite numbers"))
}

pub(super) fn field(
    field: &'static str,
    value: impl Into<String>,
    expected: impl Into<String>,
) -> FormatError {
    FormatError::HeaderField { field, value: value.into(), expected: expected.into() }
}

pub(super) fn reserved(name: &'static str, value: u32) -> Result<(), FormatError> {
    if value == 0 { Ok(()) } else { Err(field(name, format!("{value:#x}"), "0")) }
}

/// Puts fields one behind the other. The last word is the checksum of everything before it.
pub(super) struct Encoder<const N: usize> {
    bytes: [u8; N],
    at: usize,
}

impl<const N: usize> Encoder<N> {
    /// A header that begins as all of this kind do.
    pub(super) fn new(kind: &Kind) -> Self {
        let mut encoder = Self { bytes: [0; N], at: 0 };
        encoder.put(kind.magic);
        encoder.u32s(&[kind.version, N as u32]);
        encoder
    }

    fn put<const B: usize>(&mut self, bytes: [u8; B]) {
        self.bytes[self.at..self.at + B].copy_from_slice(&bytes);
        self.at += B;
    }

    pub(super) fn u32s(&mut self, values: &[u32]) {
        values.iter().for_each(|v| self.put(v.to_le_bytes()));
    }

    pub(super) fn u64s(&mut self, values: &[u64]) {
        values.iter().for_each(|v| self.put(v.to_le_bytes()));
    }

    pub(super) fn f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.put(v.to_le_bytes()));
    }

    /// Six zeros where there are none.
    pub(super) fn bounds(&mut self, bounds: Option<Bounds>) {
        let bounds = bounds.unwrap_or(Bounds { min: [0.0; 3], max: [0.0; 3] });
        self.f64s(&bounds.min);
        self.f64s(&bounds.max);
    }

    /// The section table.
    pub(super) fn sections(&mut self, sections: &[Section]) {
        for section in sections {
            self.u64s(&[section.offset, section.length]);
            self.u32s(&[section.checksum, 0]);
        }
    }

    /// The header, zeros in what was not put.
    pub(super) fn sealed(mut self) -> [u8; N] {
        let checksum = crc32fast::hash(&self.bytes[..N - 4]);
        self.at = N - 4;
        self.u32s(&[checksum]);
        self.bytes
    }
}

/// Takes fields one behind the other.
pub(super) struct Decoder<'a> {
    pub(super) bytes: &'a [u8],
}

impl Decoder<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], FormatError> {
        let Some((first, rest)) = self.bytes.split_first_chunk::<N>() else {
            let (needed, have) = (N as u64, self.bytes.len() as u64);
            return Err(FormatError::Truncated { what: "header", needed, have });
        };
        self.bytes = rest;
        Ok(*first)
    }

    pub(super) fn u32(&mut self) -> Result<u32, FormatError> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    pub(super) fn u64(&mut self) -> Result<u64, FormatError> {
        Ok(u64::from_le_bytes(self.take()?))
    }

    pub(super) fn f64(&mut self) -> Result<f64, FormatError> {
        Ok(f64::from_le_bytes(self.take()?))
    }

    pub(super) fn u32s<const N: usize>(&mut self) -> Result<[u32; N], FormatError> {
        let mut values = [0; N];
        for value in &mut values {
            *value = self.u32()?;
        }
        Ok(values)
    }

    pub(super) fn f64s<const N: usize>(&mut self) -> Result<[f64; N], FormatError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    /// The section table.
    pub(super) fn sections<const N: usize>(&mut self) -> Result<[Section; N], FormatError> {
        let mut sections = [Section::default(); N];
        for section in &mut sections {
            *section = Section { offset: self.u64()?, length: self.u64()?, checksum: self.u32()? };
            reserved("section table's reserved word", self.u32()?)?;
        }
        Ok(sections)
    }

    /// Everything that is left is zero.
    pub(super) fn end(mut self, name: &'static str) -> Result<(), FormatError> {
        while !self.bytes.is_empty() {
            reserved(name, self.u32()?)?;
        }
        Ok(())
    }
}
