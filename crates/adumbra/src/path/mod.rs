//! The path of a sun: a file with a few *key* suns, and answers for any moment between them.
//!
//! A path file holds the sun's position, step by step, and a complete shadow file for each key. For a moment
//! between two keys a ray is marched through the depths of one key. Where that march cannot decide, the other
//! key is used. The keys are placed so that the result is about as exact as a file of that very moment.
//! `spec/sun-path.md` has the file and the rules.

mod format;
mod sampler;

use std::fmt;
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use sampler::PathSampler;

use crate::error::{Error, FormatError, IoError, Result};
use crate::file::fields::field;
use crate::file::{FileMemory, ShadowFile};
use crate::grid::vec3::{dot, normalize};
use crate::path::format::{Front, HEADER_BYTES};
use crate::stream::{FileSource, ShadowSource, SourceError};

/// The key with the lower sun comes first if its sun is more than this many times nearer.
const MUCH_NEARER: f64 = 4.0;

/// The sun's position at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunStep {
    /// The moment: seconds since 1970-01-01 00:00 UTC, or since any moment for suns that were listed.
    pub seconds: f64,
    /// Unit vector towards the sun; y is negative below the horizon.
    pub towards_sun: [f64; 3],
}

/// Where the file of a key is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KeyPlace {
    pub(crate) seconds: f64,
    pub(crate) offset: u64,
    pub(crate) bytes: u64,
    /// Words of its finest level in memory.
    pub(crate) words: u64,
}

/// An open path file: the suns of a day, and the keys that answer for any moment of it. Keys are read on
/// demand.
///
/// ```no_run
/// use adumbra::{Filter, PathSampler, SunPath};
///
/// let path = SunPath::read("day.adumbra")?;
/// let noon = path.steps()[path.steps().len() / 2].seconds;
/// if let Some([first, second]) = path.keys_at(noon) {
///     let keys = [path.key(first)?, path.key(second)?];
///     let sun = path.sun_at(noon);
///     let sampler = sun.and_then(|sun| PathSampler::new([&keys[0], &keys[1]], sun, Filter::Box5));
///     let lit = sampler.map(|sampler| sampler.look_up([12.0, 0.0, 3.0], Some([0.0, 1.0, 0.0])));
///     println!("{lit:?}");
/// }
/// # Ok::<(), adumbra::Error>(())
/// ```
#[derive(Clone)]
pub struct SunPath {
    front: Front,
    source: Arc<dyn ShadowSource>,
    /// For messages.
    name: PathBuf,
}

impl SunPath {
    /// Opens a file on a disk, and reads and checks all but the keys.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the operating system fails to read the file, and [`Error::Format`] if it is
    /// not valid.
    pub fn read(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        Self::open(Arc::new(FileSource::open(path)?), path)
    }

    /// Opens a file from any source of bytes. `name` stands for it in messages.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the source fails, and [`Error::Format`] if the file is not valid.
    pub fn open(source: Arc<dyn ShadowSource>, name: impl AsRef<Path>) -> Result<Self> {
        let name = name.as_ref().to_owned();
        let read = |range| source.read(range).map_err(|error| failed(&name, error));
        let header = read(0..HEADER_BYTES as u64)?;
        let counted = Front::parse_header(&header).map_err(|fault| Error::in_file(&name, fault))?;
        let bytes = read(0..counted.tables.end())?;
        let front = counted.parse_tables(&bytes).map_err(|fault| Error::in_file(&name, fault))?;
        Ok(Self { front, source, name })
    }

    /// Writes a path file: steps, and the bytes of each key's shadow file with its time. The times of both
    /// ascend. `place_degrees` is latitude and longitude, north and east positive. Returns the length of the
    /// file.
    ///
    /// Cost: each key is decoded, one at a time, to record in the file how much memory it takes.
    ///
    /// # Errors
    /// Returns an error if a key is not a valid file, the times are out of order, a direction is not a unit
    /// vector, or writing fails.
    pub fn write(
        out: &mut dyn Write,
        steps: Vec<SunStep>,
        keys: &[(f64, Vec<u8>)],
        utc_offset_seconds: i32,
        place_degrees: Option<[f64; 2]>,
    ) -> io::Result<u64> {
        let wrong = |fault: FormatError| io::Error::new(io::ErrorKind::InvalidInput, fault);
        let sizes = keys.iter().map(|(seconds, bytes)| {
            let file = ShadowFile::from_bytes(bytes)?;
            Ok((*seconds, bytes.len() as u64, file.gpu().words().count()))
        });
        let sizes: Vec<_> = sizes.collect::<Result<_, FormatError>>().map_err(wrong)?;
        let front = Front::new(steps, &sizes, utc_offset_seconds, place_degrees).map_err(wrong)?;
        let mut head = front.encode();
        let mut end = head.len() as u64;
        for (place, (_, bytes)) in front.keys.iter().zip(keys) {
            head.resize(head.len() + (place.offset - end) as usize, 0);
            out.write_all(&head)?;
            out.write_all(bytes)?;
            head.clear();
            end = place.offset + place.bytes;
        }
        Ok(front.file_bytes)
    }

    /// Returns the sun's position, step by step.
    pub fn steps(&self) -> &[SunStep] {
        &self.front.steps
    }

    /// Returns latitude and longitude in degrees, north and east positive, if the path has a place.
    pub fn place_degrees(&self) -> Option<[f64; 2]> {
        self.front.place_degrees
    }

    /// Returns how far the local clock is ahead of UTC, in seconds.
    pub fn utc_offset_seconds(&self) -> i32 {
        self.front.utc_offset_seconds
    }

    /// Returns the length of the file in bytes.
    pub fn file_bytes(&self) -> u64 {
        self.front.file_bytes
    }

    /// Returns the times of the keys.
    pub fn key_seconds(&self) -> Vec<f64> {
        self.front.keys.iter().map(|key| key.seconds).collect()
    }

    /// Returns the unit vector towards the sun at a moment: between two steps on the shortest arc. `None`
    /// before the first step, after the last, and while the sun is at or below the horizon.
    pub fn sun_at(&self, seconds: f64) -> Option<[f64; 3]> {
        let steps = &self.front.steps;
        let after = steps.partition_point(|step| step.seconds < seconds);
        let b = steps.get(after)?;
        let towards = if b.seconds == seconds {
            b.towards_sun
        } else {
            let a = steps.get(after.checked_sub(1)?)?;
            between(a.towards_sun, b.towards_sun, (seconds - a.seconds) / (b.seconds - a.seconds))
        };
        (towards[1] > 0.0).then_some(towards)
    }

    /// Returns the keys that answer at a moment. The key with the higher sun is first, unless the other is
    /// more than four times nearer: a march towards a higher sun leaves shadows close to the edges that cast
    /// them. Before the first key, after the last and exactly at a key, both are the same key. `None` where
    /// [`SunPath::sun_at`] has no sun.
    pub fn keys_at(&self, seconds: f64) -> Option<[usize; 2]> {
        self.sun_at(seconds)?;
        let keys = &self.front.keys;
        let after = keys.partition_point(|key| key.seconds < seconds);
        let Some(b) = keys.get(after) else { return Some([keys.len() - 1; 2]) };
        let Some(before) = after.checked_sub(1) else { return Some([0; 2]) };
        if b.seconds == seconds {
            return Some([after; 2]);
        }
        let distances = [seconds - keys[before].seconds, b.seconds - seconds];
        let heights = [before, after].map(|key| self.sun_at(keys[key].seconds).map_or(0.0, |sun| sun[1]));
        let factors = if heights[0] >= heights[1] { [1.0, MUCH_NEARER] } else { [MUCH_NEARER, 1.0] };
        let is_first = factors[0] * distances[0] <= factors[1] * distances[1];
        Some(if is_first { [before, after] } else { [after, before] })
    }

    /// Reads and validates the shadow file of a key.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the source fails, and [`Error::Format`] if the key's file is not valid.
    ///
    /// # Panics
    /// Panics if there is no such key.
    pub fn key(&self, index: usize) -> Result<ShadowFile> {
        let KeyPlace { offset, bytes, words, .. } = self.front.keys[index];
        let read = self.source.read(offset..offset + bytes).map_err(|error| failed(&self.name, error))?;
        let file = ShadowFile::from_bytes(&read).map_err(|fault| Error::in_file(&self.name, fault))?;
        let found = file.gpu().words().count();
        if found != words {
            let fault = field("words of a key", words.to_string(), found.to_string());
            return Err(Error::in_file(&self.name, fault));
        }
        Ok(file)
    }

    /// Returns the memory that a key takes once it is read, and while it is read.
    ///
    /// # Errors
    /// Returns [`Error::Io`] if the source fails, and [`Error::Format`] if header, directory or tables of the
    /// key's file are not valid.
    ///
    /// # Panics
    /// Panics if there is no such key.
    #[doc(hidden)]
    pub fn key_memory(&self, index: usize) -> Result<FileMemory> {
        let source = self.key_source(index);
        FileMemory::of(
            |end| source.read(0..end).map_err(|error| failed(&self.name, error)),
            |fault| Error::in_file(&self.name, fault),
        )
    }

    /// Returns the bytes of a key's shadow file as a source, for [`stream`](crate::stream).
    ///
    /// # Panics
    /// Panics if there is no such key.
    pub fn key_source(&self, index: usize) -> Arc<dyn ShadowSource> {
        let KeyPlace { offset, bytes, .. } = self.front.keys[index];
        Arc::new(Part { source: Arc::clone(&self.source), range: offset..offset + bytes })
    }
}

impl fmt::Debug for SunPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SunPath")
            .field("front", &self.front)
            .field("name", &self.name)
            .finish_non_exhaustive()
    }
}

/// A part of a source.
struct Part {
    source: Arc<dyn ShadowSource>,
    range: Range<u64>,
}

impl ShadowSource for Part {
    fn read(&self, range: Range<u64>) -> Result<Vec<u8>, SourceError> {
        let at = |offset: u64| self.range.start.saturating_add(offset).min(self.range.end);
        self.source.read(at(range.start)..at(range.end))
    }
}

/// Interpolates between two unit vectors along the shortest arc.
fn between(a: [f64; 3], b: [f64; 3], share: f64) -> [f64; 3] {
    let angle = libm::acos(dot(a, b).clamp(-1.0, 1.0));
    let sine = libm::sin(angle);
    let weights = match sine > 1e-9 {
        true => [libm::sin((1.0 - share) * angle) / sine, libm::sin(share * angle) / sine],
        false => [1.0 - share, share],
    };
    normalize(std::array::from_fn(|i| weights[0] * a[i] + weights[1] * b[i]))
}

fn failed(name: &Path, error: SourceError) -> Error {
    IoError::at("read", name)(io::Error::other(error)).into()
}

#[cfg(test)]
mod tests;
