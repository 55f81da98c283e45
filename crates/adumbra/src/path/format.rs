//! Bytes of a path file before its keys: header and tables. `spec/sun-path.md` has the offsets.

use crate::error::FormatError;
use crate::file::fields::{Decoder, Encoder, PATH, UNIT_TOLERANCE, check_finite, field, identify};
use crate::file::sections::{Section, checked};
use crate::path::{KeyPlace, SunStep};

/// Size of the header in bytes.
pub(super) const HEADER_BYTES: usize = 128;
/// Size of a step in bytes.
const STEP_BYTES: usize = 32;
/// Size of an entry of a key in bytes.
const KEY_BYTES: usize = 32;
/// Keys begin at multiples of this many bytes.
const ALIGNMENT: u64 = 8;
/// Most steps of a path: a minute of a year each.
const MAX_STEPS: u32 = 527_040;
/// Most keys of a path.
const MAX_KEYS: u32 = 65_536;
/// Flag: the place is given.
const HAS_PLACE: u32 = 1;

/// The header and the tables, which come before the keys.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Front {
    pub(super) steps: Vec<SunStep>,
    pub(super) keys: Vec<KeyPlace>,
    pub(super) utc_offset_seconds: i32,
    pub(super) place_degrees: Option<[f64; 2]>,
    pub(super) file_bytes: u64,
}

impl Front {
    /// Places keys, each with its time, the length of its file, and its words in memory.
    pub(super) fn new(
        steps: Vec<SunStep>,
        keys: &[(f64, u64, u64)],
        utc_offset_seconds: i32,
        place_degrees: Option<[f64; 2]>,
    ) -> Result<Self, FormatError> {
        let mut end = front_bytes(steps.len(), keys.len());
        let keys = keys.iter().map(|&(seconds, bytes, words)| {
            let offset = end.next_multiple_of(ALIGNMENT);
            end = offset + bytes;
            KeyPlace { seconds, offset, bytes, words }
        });
        let keys = keys.collect();
        let front = Self { steps, keys, utc_offset_seconds, place_degrees, file_bytes: end };
        front.check()?;
        Ok(front)
    }

    /// Returns the bytes before the first key.
    pub(super) fn encode(&self) -> Vec<u8> {
        let mut tables = Vec::new();
        for SunStep { seconds, towards_sun: [x, y, z] } in &self.steps {
            [seconds, x, y, z].iter().for_each(|value| tables.extend(value.to_le_bytes()));
        }
        for KeyPlace { seconds, offset, bytes, words } in &self.keys {
            tables.extend(seconds.to_le_bytes());
            [*offset, *bytes, *words].iter().for_each(|value| tables.extend(value.to_le_bytes()));
        }
        let mut header = Encoder::<HEADER_BYTES>::new(&PATH);
        let flags = if self.place_degrees.is_some() { HAS_PLACE } else { 0 };
        header.u32s(&[flags, self.steps.len() as u32, self.keys.len() as u32]);
        header.u32s(&[self.utc_offset_seconds.cast_unsigned()]);
        header.f64s(&self.place_degrees.unwrap_or_default());
        header.u64s(&[self.file_bytes]);
        header.u32s(&[crc32fast::hash(&tables)]);
        [&header.sealed()[..], &tables].concat()
    }

    /// Reads a header. Returns it with the place of the tables.
    pub(super) fn parse_header(bytes: &[u8]) -> Result<Counted, FormatError> {
        let mut fields = identify::<HEADER_BYTES>(bytes, &PATH)?;
        let [flags, steps, keys, offset] = fields.u32s()?;
        let place = fields.f64s()?;
        let file_bytes = fields.u64()?;
        let checksum = fields.u32()?;
        fields.end("reserved words of the path's header")?;
        if flags & !HAS_PLACE != 0 {
            return Err(field("flags", format!("{flags:#x}"), "0 or 1"));
        }
        let has_place = flags & HAS_PLACE != 0;
        if !has_place && place.iter().any(|c: &f64| c.to_bits() != 0) {
            return Err(field("place", format!("{place:?}"), "zeros, because flag bit 0 is not set"));
        }
        for (name, count, most) in [("steps", steps, MAX_STEPS), ("keys", keys, MAX_KEYS)] {
            if !(1..=most).contains(&count) {
                return Err(field(name, count.to_string(), format!("from 1 to {most}")));
            }
        }
        let length = front_bytes(steps as usize, keys as usize) - HEADER_BYTES as u64;
        Ok(Counted {
            tables: Section { offset: HEADER_BYTES as u64, length, checksum },
            steps: steps as usize,
            utc_offset_seconds: offset.cast_signed(),
            place_degrees: has_place.then_some(place),
            file_bytes,
        })
    }
}

/// A header, and the place of the tables after it.
pub(super) struct Counted {
    pub(super) tables: Section,
    steps: usize,
    utc_offset_seconds: i32,
    place_degrees: Option<[f64; 2]>,
    file_bytes: u64,
}

impl Counted {
    /// Reads the tables, which are in the file's first bytes with the header.
    pub(super) fn parse_tables(&self, bytes: &[u8]) -> Result<Front, FormatError> {
        let tables = checked(bytes, self.tables, || "tables of the path".to_owned())?;
        let (steps, keys) = tables.split_at(self.steps * STEP_BYTES);
        let step = |bytes: &[u8; STEP_BYTES]| {
            let [seconds, x, y, z] = Decoder { bytes }.f64s()?;
            Ok(SunStep { seconds, towards_sun: [x, y, z] })
        };
        let key = |bytes: &[u8; KEY_BYTES]| {
            let mut fields = Decoder { bytes };
            Ok(KeyPlace {
                seconds: fields.f64()?,
                offset: fields.u64()?,
                bytes: fields.u64()?,
                words: fields.u64()?,
            })
        };
        let front = Front {
            steps: steps.as_chunks().0.iter().map(step).collect::<Result<_, FormatError>>()?,
            keys: keys.as_chunks().0.iter().map(key).collect::<Result<_, FormatError>>()?,
            utc_offset_seconds: self.utc_offset_seconds,
            place_degrees: self.place_degrees,
            file_bytes: self.file_bytes,
        };
        front.check()?;
        Ok(front)
    }
}

impl Front {
    /// Checks every value. The writer calls it too, so that nothing is written that cannot be read.
    fn check(&self) -> Result<(), FormatError> {
        if let Some([latitude, longitude]) = self.place_degrees
            && !(latitude.abs() <= 90.0 && longitude.abs() <= 180.0)
        {
            let expected = "a latitude from -90 to 90 and a longitude from -180 to 180 degrees";
            return Err(field("place", format!("{latitude}, {longitude}"), expected));
        }
        if self.utc_offset_seconds.abs() > 86_400 {
            let value = self.utc_offset_seconds.to_string();
            return Err(field("utc_offset_seconds", value, "from -86400 to 86400"));
        }
        for step in &self.steps {
            check_finite("step", &[step.seconds], step)?;
            let length = step.towards_sun.iter().map(|c| c * c).sum::<f64>();
            if !((length - 1.0).abs() <= UNIT_TOLERANCE) {
                return Err(field("step", format!("{step:?}"), "a unit vector towards the sun"));
            }
        }
        let ascends = |times: &mut dyn Iterator<Item = f64>| times.is_sorted_by(|a, b| a < b);
        if !ascends(&mut self.steps.iter().map(|step| step.seconds)) {
            return Err(field("steps", "times in another order", "times that ascend"));
        }
        if !ascends(&mut self.keys.iter().map(|key| key.seconds)) {
            return Err(field("keys", "times in another order", "times that ascend"));
        }
        let mut end = front_bytes(self.steps.len(), self.keys.len());
        for key in &self.keys {
            check_finite("key", &[key.seconds], key)?;
            let offset = end.next_multiple_of(ALIGNMENT);
            if key.offset != offset || key.bytes < crate::file::HEADER_BYTES as u64 {
                return Err(field("key", format!("{key:?}"), format!("a file at byte {offset}")));
            }
            end = offset.saturating_add(key.bytes);
        }
        if self.file_bytes != end {
            return Err(field("file_bytes", self.file_bytes.to_string(), end.to_string()));
        }
        Ok(())
    }
}

/// Returns the number of bytes of header and tables.
fn front_bytes(steps: usize, keys: usize) -> u64 {
    (HEADER_BYTES + steps * STEP_BYTES + keys * KEY_BYTES) as u64
}
