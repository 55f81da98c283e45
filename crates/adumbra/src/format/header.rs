//! The 384 bytes in front of the sections. Offsets are in `spec/adumbra-file.md`; the fields stand here in file order.

use serde::Deserialize;
use serde::de::value::{Error as ValueError, MapDeserializer};

use super::FormatError;
use crate::dag::{Dag, MAX_ROOT_LEVEL, SHADOWED, SLAB_NODE_LEVEL};
use crate::light::{LightGrid, Sun, cross, dot};
use crate::scene::Bounds;
use crate::settings::{Bias, Receivers, Settings};

/// The first eight bytes. The line break shows files that were copied as text.
pub const MAGIC: [u8; 8] = *b"ADUMBRA\n";
/// The version that is written, and the latest that is read.
pub const VERSION: u32 = 1;
/// Bytes of the header.
pub const HEADER_BYTES: usize = 384;

/// The header's checksum is its last word and covers everything before it.
const CHECKSUM_AT: usize = HEADER_BYTES - 4;
/// Sections begin at multiples of this.
const ALIGNMENT: u64 = 16;
/// How far axes may be from orthonormal and the sun from a unit vector: far above rounding, far below a texel.
const UNIT_TOLERANCE: f64 = 1e-9;

const ASSUME_GROUND: u32 = 1;
const CLOSED_REGIONS: u32 = 1 << 1;
const IGNORE_ALPHA: u32 = 1 << 2;
const STATIC_RECEIVERS: u32 = 1 << 3;
const HAS_BOUNDS: u32 = 1 << 4;
const ALL_FLAGS: u32 = (1 << 5) - 1;

/// Section names, in file order.
pub(super) const SECTIONS: [&str; 3] = ["top", "nodes", "slabs"];
/// Bytes of one element of each section.
const ELEMENT_BYTES: [u64; 3] = [4, 4, 8];

/// One row of the section table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Section {
    pub(super) offset: u64,
    pub(super) length: u64,
    pub(super) checksum: u32,
}

impl Section {
    pub(super) fn end(&self) -> u64 {
        self.offset.saturating_add(self.length)
    }
}

/// Where the sections of these lengths lie; checksums are left at 0.
pub(super) fn lay_out(lengths: [u64; 3]) -> [Section; 3] {
    let mut end = HEADER_BYTES as u64;
    lengths.map(|length| {
        let section = Section { offset: align(end), length, checksum: 0 };
        end = section.end();
        section
    })
}

fn align(offset: u64) -> u64 {
    offset.checked_next_multiple_of(ALIGNMENT).unwrap_or(u64::MAX)
}

/// A header whose every field has been checked.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub(super) grid: LightGrid,
    pub(super) settings: Settings,
    pub(super) root_level: u32,
    pub(super) top_dims: [u32; 3],
    pub(super) sections: [Section; 3],
}

impl Header {
    /// The one length that a file with this header has.
    pub(super) fn file_bytes(&self) -> u64 {
        self.sections[2].end()
    }

    pub(super) fn encode(&self) -> [u8; HEADER_BYTES] {
        let (grid, settings) = (&self.grid, &self.settings);
        let bounds = settings.bounds.unwrap_or(Bounds { min: [0.0; 3], max: [0.0; 3] });
        let mut out = Encoder { bytes: [0; HEADER_BYTES], at: 0 };
        out.put(MAGIC);
        out.u32s(&[VERSION, HEADER_BYTES as u32, flags(settings), settings.resolution]);
        out.u32s(&grid.size);
        out.u32s(&[self.root_level]);
        out.u32s(&self.top_dims);
        out.u32s(&[0]);
        out.f64s(&[grid.voxel_size]);
        out.f64s(&grid.sun.towards());
        out.f64s(&grid.origin);
        out.f64s(grid.axes.as_flattened());
        out.f64s(&[settings.thickness_world]);
        let bias = settings.bias;
        out.f64s(&[bias.constant_texels, bias.slope_texels, bias.normal_offset_texels]);
        out.f64s(&bounds.min);
        out.f64s(&bounds.max);
        out.put(settings.triangles.to_le_bytes());
        out.put(settings.instances.to_le_bytes());
        for section in &self.sections {
            out.put(section.offset.to_le_bytes());
            out.put(section.length.to_le_bytes());
            out.u32s(&[section.checksum, 0]);
        }
        let checksum = crc32fast::hash(&out.bytes[..CHECKSUM_AT]);
        out.at = CHECKSUM_AT;
        out.u32s(&[checksum]);
        out.bytes
    }

    /// Reads and checks the header at the front of `bytes`.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, FormatError> {
        let header = identify(bytes)?;
        let mut fields = Decoder { bytes: &header[16..CHECKSUM_AT] };
        let flags = fields.u32()?;
        let resolution = fields.u32()?;
        let size = fields.u32s()?;
        let root_level = fields.u32()?;
        let top_dims = fields.u32s()?;
        reserved("reserved word 13", fields.u32()?)?;
        let voxel_size = fields.f64()?;
        let towards = fields.f64s()?;
        let origin = fields.f64s()?;
        let axes = [fields.f64s()?, fields.f64s()?, fields.f64s()?];
        let thickness_world = fields.f64()?;
        let [constant_texels, slope_texels, normal_offset_texels] = fields.f64s()?;
        let bounds = Bounds { min: fields.f64s()?, max: fields.f64s()? };
        let (triangles, instances) = (fields.u64()?, fields.u64()?);
        let mut sections = [Section::default(); 3];
        for section in &mut sections {
            *section = Section { offset: fields.u64()?, length: fields.u64()?, checksum: fields.u32()? };
            reserved("section table's reserved word", fields.u32()?)?;
        }
        while !fields.bytes.is_empty() {
            reserved("reserved words 88 to 94", fields.u32()?)?;
        }

        if flags & !ALL_FLAGS != 0 {
            return Err(field("flags", format!("{flags:#x}"), "made of bits 0 to 4 only"));
        }
        let has_bounds = flags & HAS_BOUNDS != 0;
        if !has_bounds && bounds.min.iter().chain(&bounds.max).any(|c| c.to_bits() != 0) {
            return Err(field(
                "bounds",
                format!("{bounds:?}"),
                "zero, as flag bit 4 says that there are none",
            ));
        }
        let grid = LightGrid { sun: sun(towards)?, voxel_size, origin, axes, size };
        let settings = Settings {
            resolution,
            thickness_world,
            assume_ground: flags & ASSUME_GROUND != 0,
            closed_regions: flags & CLOSED_REGIONS != 0,
            ignore_alpha: flags & IGNORE_ALPHA != 0,
            receivers: if flags & STATIC_RECEIVERS != 0 { Receivers::Static } else { Receivers::All },
            bounds: has_bounds.then_some(bounds),
            bias: Bias { constant_texels, slope_texels, normal_offset_texels },
            triangles,
            instances,
        };
        let header = Self { grid, settings, root_level, top_dims, sections };
        header.check()?;
        Ok(header)
    }

    /// Checks every value; the writer calls it too, so that nothing is written that cannot be read.
    pub(super) fn check(&self) -> Result<(), FormatError> {
        check_settings(&self.settings)?;
        check_grid(&self.grid)?;
        let level = self.root_level;
        if !(SLAB_NODE_LEVEL..=MAX_ROOT_LEVEL).contains(&level) {
            return Err(field("root_level", level.to_string(), "from 3 to 20"));
        }
        let dims = Dag::top_dims_covering(self.grid.size, level);
        if self.top_dims != dims {
            let expected = format!("{dims:?}, as size {:?} and root_level {level} ask for", self.grid.size);
            return Err(field("top_dims", format!("{:?}", self.top_dims), expected));
        }
        self.check_sections()
    }

    fn check_sections(&self) -> Result<(), FormatError> {
        let roots = self.top_dims.iter().try_fold(4_u64, |n, &d| n.checked_mul(u64::from(d)));
        let mut end = HEADER_BYTES as u64;
        for (i, s) in self.sections.iter().enumerate() {
            let bounds = |field, value, expected| FormatError::SectionBounds {
                section: SECTIONS[i],
                field,
                value,
                expected,
            };
            if s.offset != align(end) {
                return Err(bounds("offset", s.offset, align(end).to_string()));
            }
            let limit = if i == 1 { 4 * u64::from(SHADOWED) } else { 8 << 32 };
            if i == 0 && Some(s.length) != roots {
                let roots = roots.map_or("more than a file can hold".to_owned(), |r| r.to_string());
                return Err(bounds("length", s.length, roots));
            }
            if s.length % ELEMENT_BYTES[i] != 0 || s.length > limit && i > 0 {
                let expected = format!("a multiple of {} up to {limit}", ELEMENT_BYTES[i]);
                return Err(bounds("length", s.length, expected));
            }
            end = s.end();
        }
        Ok(())
    }
}

/// Checks what makes the bytes a header of this version: magic, version, length, checksum.
fn identify(bytes: &[u8]) -> Result<&[u8; HEADER_BYTES], FormatError> {
    let start = &bytes[..bytes.len().min(MAGIC.len())];
    if !MAGIC.starts_with(start) {
        return Err(FormatError::Magic { found: start.to_vec() });
    }
    // A version that is not ours may have a shorter header, so it is looked at before the length.
    let mut fields = Decoder { bytes: bytes.get(MAGIC.len()..16).unwrap_or_default() };
    if let (Ok(version), Ok(length)) = (fields.u32(), fields.u32()) {
        if version > VERSION {
            return Err(FormatError::FutureVersion { version, supported: VERSION });
        }
        if version != VERSION {
            return Err(field("version", version.to_string(), VERSION.to_string()));
        }
        if length != HEADER_BYTES as u32 {
            return Err(field("header_bytes", length.to_string(), HEADER_BYTES.to_string()));
        }
    }
    let Some(header) = bytes.first_chunk::<HEADER_BYTES>() else {
        let (needed, have) = (HEADER_BYTES as u64, bytes.len() as u64);
        return Err(FormatError::Truncated { what: "header", needed, have });
    };
    let computed = crc32fast::hash(&header[..CHECKSUM_AT]);
    let stored = Decoder { bytes: &header[CHECKSUM_AT..] }.u32()?;
    if stored == computed { Ok(header) } else { Err(FormatError::HeaderChecksum { stored, computed }) }
}

fn check_settings(settings: &Settings) -> Result<(), FormatError> {
    if settings.resolution == 0 {
        return Err(field("resolution", "0", "at least 1"));
    }
    let thickness = settings.thickness_world;
    if !(thickness.is_finite() && thickness >= 0.0) {
        return Err(field("thickness", thickness.to_string(), "a finite number, zero or more"));
    }
    let bias = settings.bias;
    if ![bias.constant_texels, bias.slope_texels, bias.normal_offset_texels].iter().all(|b| b.is_finite()) {
        return Err(field("bias", format!("{bias:?}"), "finite numbers"));
    }
    if let Some(b) = settings.bounds
        && !(0..3).all(|a| b.min[a].is_finite() && b.max[a].is_finite() && b.min[a] <= b.max[a])
    {
        return Err(field("bounds", format!("{b:?}"), "finite, the minimum not above the maximum"));
    }
    Ok(())
}

fn check_grid(grid: &LightGrid) -> Result<(), FormatError> {
    if grid.size.contains(&0) {
        return Err(field("size", format!("{:?}", grid.size), "at least 1 along each axis"));
    }
    if !(grid.voxel_size.is_finite() && grid.voxel_size > 0.0) {
        return Err(field("voxel_size", grid.voxel_size.to_string(), "a finite number above zero"));
    }
    if !grid.origin.iter().all(|c| c.is_finite()) {
        return Err(field("origin", format!("{:?}", grid.origin), "finite numbers"));
    }
    let [x, y, z] = grid.axes;
    let to_sun = grid.sun.towards();
    // Written so that a NaN anywhere fails.
    let unit = [x, y, z].iter().all(|a| (dot(*a, *a) - 1.0).abs() <= UNIT_TOLERANCE);
    let square = [dot(x, y), dot(y, z), dot(z, x)].iter().all(|d| d.abs() <= UNIT_TOLERANCE);
    let right_handed = dot(cross(x, y), z) > 0.0;
    let along_light = (0..3).all(|a| (z[a] + to_sun[a]).abs() <= UNIT_TOLERANCE);
    if !(unit && square && right_handed && along_light) {
        let expected = "orthonormal and right-handed, the third away from the sun";
        return Err(field("axes", format!("{:?}", grid.axes), expected));
    }
    Ok(())
}

/// The sun with exactly these bits: [`Sun::from_direction`] would normalise once more and change the last ones.
fn sun(towards: [f64; 3]) -> Result<Sun, FormatError> {
    let unit = (dot(towards, towards) - 1.0).abs() <= UNIT_TOLERANCE;
    let entry = std::iter::once(("towards", towards.to_vec()));
    match Sun::deserialize(MapDeserializer::<_, ValueError>::new(entry)) {
        Ok(sun) if unit && towards[1] > 0.0 => Ok(sun),
        _ => Err(field("sun", format!("{towards:?}"), "a unit vector with y above zero")),
    }
}

fn flags(settings: &Settings) -> u32 {
    let bit = |set: bool, flag: u32| if set { flag } else { 0 };
    bit(settings.assume_ground, ASSUME_GROUND)
        | bit(settings.closed_regions, CLOSED_REGIONS)
        | bit(settings.ignore_alpha, IGNORE_ALPHA)
        | bit(settings.receivers == Receivers::Static, STATIC_RECEIVERS)
        | bit(settings.bounds.is_some(), HAS_BOUNDS)
}

pub(super) fn field(
    field: &'static str,
    value: impl Into<String>,
    expected: impl Into<String>,
) -> FormatError {
    FormatError::HeaderField { field, value: value.into(), expected: expected.into() }
}

fn reserved(name: &'static str, value: u32) -> Result<(), FormatError> {
    if value == 0 { Ok(()) } else { Err(field(name, format!("{value:#x}"), "0")) }
}

/// Puts fields one behind the other.
struct Encoder {
    bytes: [u8; HEADER_BYTES],
    at: usize,
}

impl Encoder {
    fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        self.bytes[self.at..self.at + N].copy_from_slice(&bytes);
        self.at += N;
    }

    fn u32s(&mut self, values: &[u32]) {
        values.iter().for_each(|v| self.put(v.to_le_bytes()));
    }

    fn f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.put(v.to_le_bytes()));
    }
}

/// Takes fields one behind the other.
struct Decoder<'a> {
    bytes: &'a [u8],
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

    fn u32(&mut self) -> Result<u32, FormatError> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    fn u64(&mut self) -> Result<u64, FormatError> {
        Ok(u64::from_le_bytes(self.take()?))
    }

    fn f64(&mut self) -> Result<f64, FormatError> {
        Ok(f64::from_le_bytes(self.take()?))
    }

    fn u32s(&mut self) -> Result<[u32; 3], FormatError> {
        Ok([self.u32()?, self.u32()?, self.u32()?])
    }

    fn f64s(&mut self) -> Result<[f64; 3], FormatError> {
        Ok([self.f64()?, self.f64()?, self.f64()?])
    }
}
