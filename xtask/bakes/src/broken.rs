//! Broken files: each is a valid one with one fault and corrected checksums, and the error that it must
//! cause.

use std::fs;
use std::io;
use std::path::Path;

use serde_json::json;

pub(crate) struct Broken {
    pub(crate) name: &'static str,
    /// Name of the error.
    pub(crate) error: &'static str,
    /// Name of the fault, for the errors "Graph", "Packed", "Depths" and "Tree".
    pub(crate) fault: Option<&'static str>,
    /// The field or section that is wrong. The message must name it.
    pub(crate) names: &'static str,
    pub(crate) bytes: Vec<u8>,
}

impl Broken {
    fn expected(&self) -> String {
        let fault = self.fault.map_or(String::new(), |f| format!(", \"fault\": {}", json!(f)));
        format!("{{\"error\": {}{fault}, \"names\": {}}}\n", json!(self.error), json!(self.names))
    }
}

/// Writes a folder for each fault below `folder`.
pub(crate) fn write(all: &[Broken], folder: &Path) -> io::Result<()> {
    for broken in all {
        let fault = folder.join(broken.name);
        fs::create_dir_all(&fault)?;
        fs::write(fault.join("file.adumbra"), &broken.bytes)?;
        fs::write(fault.join("expected.json"), broken.expected())?;
    }
    Ok(())
}

/// A file that is being broken. Its header has `HEADER` bytes, and its table of three sections starts at byte
/// `TABLE`.
#[derive(Clone)]
pub(crate) struct Bytes<const TABLE: usize, const HEADER: usize>(pub(crate) Vec<u8>);

impl<const TABLE: usize, const HEADER: usize> Bytes<TABLE, HEADER> {
    pub(crate) const HEADER_BYTES: usize = HEADER;

    pub(crate) fn word(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.0[at..at + 4].try_into().expect("four bytes"))
    }

    pub(crate) fn put(mut self, at: usize, bytes: &[u8]) -> Self {
        self.0[at..at + bytes.len()].copy_from_slice(bytes);
        self
    }

    pub(crate) fn put_word(self, at: usize, word: u32) -> Self {
        self.put(at, &word.to_le_bytes())
    }

    pub(crate) fn put_f64(self, at: usize, value: f64) -> Self {
        self.put(at, &value.to_le_bytes())
    }

    /// Removes everything after byte `length`.
    pub(crate) fn cut(mut self, length: usize) -> Self {
        self.0.truncate(length);
        self
    }

    /// Byte offset of a section.
    pub(crate) fn section(&self, section: usize) -> usize {
        self.word(TABLE + 24 * section) as usize
    }

    /// Recomputes all checksums.
    pub(crate) fn sealed(mut self) -> Vec<u8> {
        for row in [TABLE, TABLE + 24, TABLE + 48] {
            let (from, length) = (self.word(row) as usize, self.word(row + 8) as usize);
            if let Some(bytes) = self.0.get(from..from.saturating_add(length)) {
                let checksum = crc32(bytes);
                self = self.put_word(row + 16, checksum);
            }
        }
        let checksum = crc32(&self.0[..HEADER - 4]);
        self.put_word(HEADER - 4, checksum).0
    }
}

/// CRC-32 (IEEE), bit by bit.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, _: u32| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, &b| (0..8).fold(crc ^ u32::from(b), step))
}
