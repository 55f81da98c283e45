//! Reading, writing and checking the header fields that all kinds of file share. They are public for crates
//! that define another kind, as `adumbra-papers` does.

use crate::error::FormatError;
use crate::file::sections::Section;
use crate::grid::vec3::dot;
use crate::grid::{Bounds, Sun};

/// Tolerance for orthonormal axes and for the sun as a unit vector. It is far above rounding errors and far
/// below a texel.
pub const UNIT_TOLERANCE: f64 = 1e-9;

/// Size in bytes of magic, version and header length, with which every kind of file begins.
const FRONT_BYTES: usize = 16;

/// A kind of file, with the values of its first bytes.
pub struct Kind {
    /// The first eight bytes.
    pub magic: [u8; 8],
    /// The magic as shown in messages.
    pub shown: &'static str,
    /// The name of such a file in messages.
    pub name: &'static str,
    /// The version that is written and read.
    pub version: u32,
}

/// A file with a light-aligned grid.
pub const LIGHT: Kind =
    Kind { magic: *b"ADUMBRA\n", shown: "\"ADUMBRA\\n\"", name: "light-aligned shadow file", version: 4 };
/// A file with the path of a sun.
pub const PATH: Kind = Kind { magic: *b"ADUMDAY\n", shown: "\"ADUMDAY\\n\"", name: "sun path", version: 1 };

/// Whether a file that begins with these bytes is the path of a sun.
pub fn is_path(bytes: &[u8]) -> bool {
    bytes.starts_with(&PATH.magic)
}

/// Checks that `bytes` begin with a header of this kind: magic, version, length, and checksum in the last
/// word. Returns the fields between.
///
/// # Errors
/// Returns the fault with the values found: the magic, the version, the length or the checksum.
pub fn identify<'a, const N: usize>(bytes: &'a [u8], kind: &Kind) -> Result<Decoder<'a>, FormatError> {
    let start = &bytes[..bytes.len().min(kind.magic.len())];
    if !kind.magic.starts_with(start) {
        return Err(match [LIGHT, PATH].iter().find(|other| other.magic == start) {
            Some(other) => FormatError::OtherKind { found: other.name, needed: kind.name },
            None => FormatError::Magic { found: start.to_vec(), expected: kind.shown },
        });
    }
    // Another version may have a shorter header, so the version is checked before the length.
    let mut fields = Decoder { bytes: bytes.get(kind.magic.len()..FRONT_BYTES).unwrap_or_default() };
    if let (Ok(version), Ok(length)) = (fields.u32(), fields.u32()) {
        if version > kind.version {
            return Err(FormatError::FutureVersion { version, supported: kind.version });
        }
        if version < kind.version {
            return Err(field("version", version.to_string(), kind.version.to_string()));
        }
        if length != N as u32 {
            return Err(field("header_bytes", length.to_string(), N.to_string()));
        }
    }
    let Some(header) = bytes.first_chunk::<N>() else {
        let (needed, have) = (N as u64, bytes.len() as u64);
        return Err(FormatError::Truncated { what: "header".into(), needed, have });
    };
    let (covered, last) = header.split_at(N - 4);
    let computed = crc32fast::hash(covered);
    let stored = Decoder { bytes: last }.u32()?;
    if stored == computed {
        Ok(Decoder { bytes: &covered[FRONT_BYTES..] })
    } else {
        Err(FormatError::HeaderChecksum { stored, computed })
    }
}

/// Returns a stored sun, bit for bit.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] if it is not a unit vector with y above zero.
pub fn sun(towards: [f64; 3]) -> Result<Sun, FormatError> {
    let unit = (dot(towards, towards) - 1.0).abs() <= UNIT_TOLERANCE;
    if unit && towards[1] > 0.0 {
        return Ok(Sun::from_stored(towards));
    }
    Err(field("sun", format!("{towards:?}"), "a unit vector with y above zero"))
}

/// Returns the bounds if they are present according to their flag. If they are not, all their bits must be
/// zero.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] if the bounds are absent but a bit is set.
pub fn bounds(there: bool, flag: &str, bounds: Bounds) -> Result<Option<Bounds>, FormatError> {
    if !there && bounds.min.iter().chain(&bounds.max).any(|c| c.to_bits() != 0) {
        let expected = format!("zero, because flag bit {flag} is not set");
        return Err(field("bounds", format!("{bounds:?}"), expected));
    }
    Ok(there.then_some(bounds))
}

/// Checks that a box is finite and not inverted.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] if it is not.
pub fn check_bounds(bounds: &Option<Bounds>) -> Result<(), FormatError> {
    if let Some(b) = bounds
        && !(0..3).all(|a| b.min[a].is_finite() && b.max[a].is_finite() && b.min[a] <= b.max[a])
    {
        return Err(field("bounds", format!("{b:?}"), "finite, with no minimum above its maximum"));
    }
    Ok(())
}

/// Checks the edge length of a voxel.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] if it is not a finite number above zero.
pub fn check_voxel_size(size: f64) -> Result<(), FormatError> {
    if size.is_finite() && size > 0.0 {
        return Ok(());
    }
    Err(field("voxel_size", size.to_string(), "a finite number above zero"))
}

/// Checks that all `values` of a field are finite.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] with the field as `shown` if one is not.
pub fn check_finite(
    name: &'static str,
    values: &[f64],
    shown: impl std::fmt::Debug,
) -> Result<(), FormatError> {
    if values.iter().all(|v| v.is_finite()) {
        return Ok(());
    }
    Err(field(name, format!("{shown:?}"), "finite numbers"))
}

/// Returns the error for a field with a value that is not allowed.
pub fn field(field: &'static str, value: impl Into<String>, expected: impl Into<String>) -> FormatError {
    FormatError::HeaderField { field, value: value.into(), expected: expected.into() }
}

/// Checks that a reserved word is zero.
///
/// # Errors
/// Returns [`FormatError::HeaderField`] if it is not.
pub fn reserved(name: &'static str, value: u32) -> Result<(), FormatError> {
    if value == 0 { Ok(()) } else { Err(field(name, format!("{value:#x}"), "0")) }
}

/// Writes header fields one after the other. The last word is the checksum of everything before it.
pub struct Encoder<const N: usize> {
    bytes: [u8; N],
    at: usize,
}

impl<const N: usize> Encoder<N> {
    /// Begins a header of this kind with its magic, version and length.
    pub fn new(kind: &Kind) -> Self {
        let mut encoder = Self::blank();
        encoder.put(kind.magic);
        encoder.u32s(&[kind.version, N as u32]);
        encoder
    }

    /// Begins a record without magic and checksum.
    pub fn blank() -> Self {
        Self { bytes: [0; N], at: 0 }
    }

    fn put<const B: usize>(&mut self, bytes: [u8; B]) {
        self.bytes[self.at..self.at + B].copy_from_slice(&bytes);
        self.at += B;
    }

    /// Writes 32-bit words.
    pub fn u32s(&mut self, values: &[u32]) {
        values.iter().for_each(|v| self.put(v.to_le_bytes()));
    }

    /// Writes 64-bit words.
    pub fn u64s(&mut self, values: &[u64]) {
        values.iter().for_each(|v| self.put(v.to_le_bytes()));
    }

    /// Writes 64-bit floating-point numbers.
    pub fn f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.put(v.to_le_bytes()));
    }

    /// Writes bounds, or six zeros for `None`.
    pub fn bounds(&mut self, bounds: Option<Bounds>) {
        let bounds = bounds.unwrap_or(Bounds { min: [0.0; 3], max: [0.0; 3] });
        self.f64s(&bounds.min);
        self.f64s(&bounds.max);
    }

    /// Writes the section table.
    pub fn sections(&mut self, sections: &[Section]) {
        for section in sections {
            self.u64s(&[section.offset, section.length]);
            self.u32s(&[section.checksum, 0]);
        }
    }

    /// Returns the record without a checksum. Bytes that were not written are zero.
    pub fn bytes(self) -> [u8; N] {
        self.bytes
    }

    /// Returns the header with its checksum. Bytes that were not written are zero.
    pub fn sealed(mut self) -> [u8; N] {
        let checksum = crc32fast::hash(&self.bytes[..N - 4]);
        self.at = N - 4;
        self.u32s(&[checksum]);
        self.bytes
    }
}

/// Reads header fields one after the other.
pub struct Decoder<'a> {
    /// The bytes that have not been read.
    pub bytes: &'a [u8],
}

impl Decoder<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], FormatError> {
        let Some((first, rest)) = self.bytes.split_first_chunk::<N>() else {
            let (needed, have) = (N as u64, self.bytes.len() as u64);
            return Err(FormatError::Truncated { what: "header".into(), needed, have });
        };
        self.bytes = rest;
        Ok(*first)
    }

    /// Reads the next 32-bit word.
    ///
    /// # Errors
    /// Returns [`FormatError::Truncated`] if the header ends before it.
    pub fn u32(&mut self) -> Result<u32, FormatError> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    /// Reads the next 64-bit word.
    ///
    /// # Errors
    /// Returns [`FormatError::Truncated`] if the header ends before it.
    pub fn u64(&mut self) -> Result<u64, FormatError> {
        Ok(u64::from_le_bytes(self.take()?))
    }

    /// Reads the next 64-bit floating-point number.
    ///
    /// # Errors
    /// Returns [`FormatError::Truncated`] if the header ends before it.
    pub fn f64(&mut self) -> Result<f64, FormatError> {
        Ok(f64::from_le_bytes(self.take()?))
    }

    /// Reads the next `N` 32-bit words.
    ///
    /// # Errors
    /// Returns [`FormatError::Truncated`] if the header ends before them.
    pub fn u32s<const N: usize>(&mut self) -> Result<[u32; N], FormatError> {
        let mut values = [0; N];
        for value in &mut values {
            *value = self.u32()?;
        }
        Ok(values)
    }

    /// Reads the next `N` 64-bit floating-point numbers.
    ///
    /// # Errors
    /// Returns [`FormatError::Truncated`] if the header ends before them.
    pub fn f64s<const N: usize>(&mut self) -> Result<[f64; N], FormatError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    /// Reads a section table of `N` entries.
    ///
    /// # Errors
    /// Returns [`FormatError::Truncated`] if the header ends before them, and [`FormatError::HeaderField`] if
    /// a reserved word is not zero.
    pub fn sections<const N: usize>(&mut self) -> Result<[Section; N], FormatError> {
        let mut sections = [Section::default(); N];
        for section in &mut sections {
            *section = Section { offset: self.u64()?, length: self.u64()?, checksum: self.u32()? };
            reserved("section table's reserved word", self.u32()?)?;
        }
        Ok(sections)
    }

    /// Checks that all remaining fields are zero.
    ///
    /// # Errors
    /// Returns [`FormatError::HeaderField`] with `name` if one is not.
    pub fn end(mut self, name: &'static str) -> Result<(), FormatError> {
        while !self.bytes.is_empty() {
            reserved(name, self.u32()?)?;
        }
        Ok(())
    }
}
