//! A shadow file that is being broken: the offsets of its parts, and its checksums.

use crate::broken::crc32;

/// The bytes of a valid file.
#[derive(Clone)]
pub(super) struct ShadowBytes(pub(super) Vec<u8>);

const HEADER: usize = 256;
const GRID: usize = 256;
const ENTRY: usize = 24;

impl ShadowBytes {
    pub(super) fn word(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.0[at..at + 4].try_into().expect("four bytes"))
    }

    pub(super) fn put(mut self, at: usize, bytes: &[u8]) -> Self {
        self.0[at..at + bytes.len()].copy_from_slice(bytes);
        self
    }

    pub(super) fn put_word(self, at: usize, word: u32) -> Self {
        self.put(at, &word.to_le_bytes())
    }

    pub(super) fn put_f64(self, at: usize, value: f64) -> Self {
        self.put(at, &value.to_le_bytes())
    }

    /// Removes everything after byte `length`.
    pub(super) fn cut(mut self, length: usize) -> Self {
        self.0.truncate(length);
        self
    }

    fn grids(&self) -> usize {
        self.word(24) as usize
    }

    /// Returns offset and length of a section of a grid, 0 = table, 1 = common section, 2 = bundles.
    fn section(&self, level: usize, section: usize) -> [usize; 2] {
        let at = HEADER + GRID * level + 160 + 24 * section;
        [self.word(at) as usize, self.word(at + 8) as usize]
    }

    /// Byte offset of a level's table.
    pub(super) fn table(&self, level: usize) -> usize {
        self.section(level, 0)[0]
    }

    /// Byte offset of a level's common section.
    pub(super) fn common(&self, level: usize) -> usize {
        self.section(level, 1)[0]
    }

    /// Number of bundles of a level.
    pub(super) fn bundles(&self, level: usize) -> usize {
        self.section(level, 0)[1] / ENTRY
    }

    /// Byte offset of a bundle.
    pub(super) fn bundle(&self, level: usize, index: usize) -> usize {
        let before = (0..index).map(|i| self.word(self.table(level) + ENTRY * i) as usize);
        self.section(level, 2)[0] + before.sum::<usize>()
    }

    /// Swaps two bundles of a level, and nothing else.
    pub(super) fn swapped(mut self, level: usize, one: usize, other: usize) -> Vec<u8> {
        let range = |bytes: &Self, index: usize| {
            let at = bytes.bundle(level, index);
            at..at + bytes.word(bytes.table(level) + ENTRY * index) as usize
        };
        let (a, b) = (range(&self, one), range(&self, other));
        let swapped = [&self.0[b.clone()], &self.0[a.end..b.start], &self.0[a.clone()]].concat();
        self.0.splice(a.start..b.end, swapped);
        self.0
    }

    /// Returns the stored bytes of a level's common section.
    pub(super) fn stored_common(&self, level: usize) -> Vec<u8> {
        let [from, length] = self.section(level, 1);
        self.0[from..from + length].to_vec()
    }

    /// Replaces the common section of the finest level. The bundles behind it are the last part of the file.
    pub(super) fn with_common(mut self, stored: &[u8], raw_bytes: u32) -> Self {
        let [from, length] = self.section(0, 1);
        self.0.splice(from..from + length, stored.iter().copied());
        let (bundles, file_bytes) = ((from + stored.len()) as u32, self.0.len() as u32);
        self.put_word(HEADER + 192, stored.len() as u32)
            .put_word(HEADER + 232, raw_bytes)
            .put_word(HEADER + 208, bundles)
            .put_word(136, file_bytes)
    }

    /// Returns the stored bytes of the last bundle, with which the file ends.
    pub(super) fn last_bundle(&self) -> Vec<u8> {
        self.0[self.bundle(0, self.bundles(0) - 1)..].to_vec()
    }

    /// Replaces the last bundle.
    pub(super) fn with_last_bundle(mut self, stored: &[u8]) -> Self {
        let last = self.bundles(0) - 1;
        self.0.truncate(self.bundle(0, last));
        self.0.extend_from_slice(stored);
        let [from, _] = self.section(0, 2);
        let (row, file_bytes) = (self.table(0) + ENTRY * last, self.0.len() as u32);
        self.put_word(row, stored.len() as u32)
            .put_word(HEADER + 216, file_bytes - from as u32)
            .put_word(136, file_bytes)
    }

    /// Makes the only page of the file uniform, with bytes that are not needed.
    pub(super) fn uniform_with_bytes(mut self) -> Vec<u8> {
        let bundle = self.bundle(0, 0);
        let words = self.word(bundle + 8);
        self.0.truncate(bundle + 192);
        let grid = HEADER;
        let table = self.table(0);
        let file_bytes = self.0.len() as u32;
        assert!(words > 0, "the page has words");
        self.put_word(bundle, u32::MAX)
            .put_word(bundle + 8, 0)
            .put_word(table, 192)
            .put_word(table + 4, 192)
            .put_word(grid + 216, 192)
            .put_word(136, file_bytes)
            .sealed()
    }

    /// Recomputes all checksums.
    pub(super) fn sealed(mut self) -> Vec<u8> {
        for level in 0..self.grids() {
            for index in 0..self.bundles(level) {
                let (at, entry) = (self.bundle(level, index), self.table(level) + ENTRY * index);
                let length = self.word(entry) as usize;
                if length > 0
                    && let Some(bytes) = self.0.get(at..at + length)
                {
                    let checksum = crc32(bytes);
                    self = self.put_word(entry + 8, checksum);
                }
            }
        }
        self.sealed_front()
    }

    /// Recomputes the checksums of tables, common sections, directory and header.
    pub(super) fn sealed_front(mut self) -> Vec<u8> {
        for level in 0..self.grids() {
            for section in [0, 1] {
                let [from, length] = self.section(level, section);
                if let Some(bytes) = self.0.get(from..from.saturating_add(length)) {
                    let checksum = crc32(bytes);
                    self = self.put_word(HEADER + GRID * level + 176 + 24 * section, checksum);
                }
            }
        }
        let directory = crc32(&self.0[HEADER..HEADER + GRID * self.grids()]);
        self.put_word(132, directory).sealed_header()
    }

    /// Recomputes the checksum of the header.
    pub(super) fn sealed_header(self) -> Vec<u8> {
        let checksum = crc32(&self.0[..HEADER - 4]);
        self.put_word(HEADER - 4, checksum).0
    }
}
