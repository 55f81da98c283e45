//! Damages files that have a header with a table of three sections, and repairs their checksums.

/// Offsets and sizes of a kind of file.
pub(crate) struct Layout {
    /// Size of the header in bytes. The checksum is its last word.
    pub(crate) header_bytes: usize,
    /// Offset of the section table in bytes.
    pub(crate) table: usize,
    /// Sections in which elements may be inserted or removed, each with the size of an element in bytes.
    pub(crate) resizable: [(usize, usize); 2],
    /// Words that have a special meaning somewhere in the file.
    pub(crate) values: &'static [u32],
    /// Distance between neighbouring items that a word may refer to.
    pub(crate) step: u32,
}

/// Size of an entry of the section table in bytes.
const ROW: usize = 24;

impl Layout {
    /// Returns the bytes that a fuzzer's input represents. If the first byte is odd (as in `A`), the input is
    /// the file as it is. If it is even (as in `@`), the file begins with `A` instead, and its checksums are
    /// repaired.
    pub(crate) fn interpret(&self, input: &[u8]) -> Vec<u8> {
        let mut bytes = input.to_vec();
        if let Some(first) = bytes.first_mut()
            && *first & 1 == 0
        {
            *first = b'A';
            self.repair(&mut bytes);
        }
        bytes
    }

    /// Returns `valid` with one to four faults that follow from `seed`. In most cases the checksums are
    /// repaired, in some the sections are resized.
    pub(crate) fn mutate(&self, valid: &[u8], seed: u64) -> Vec<u8> {
        Mutator { state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1, layout: self }.mutate(valid)
    }

    /// Repairs the checksums of the header and of the sections that are within the file.
    fn repair(&self, bytes: &mut [u8]) {
        if bytes.len() < self.header_bytes {
            return;
        }
        for row in [0, 1, 2].map(|i| self.table + i * ROW) {
            let (from, length) = (u64_at(bytes, row), u64_at(bytes, row + 8));
            let end = from.saturating_add(length).min(usize::MAX as u64);
            if let Some(section) = bytes.get(from as usize..end as usize) {
                let checksum = crc32fast::hash(section);
                put_u32(bytes, row + 16, checksum);
            }
        }
        let checksum = crc32fast::hash(&bytes[..self.header_bytes - 4]);
        put_u32(bytes, self.header_bytes - 4, checksum);
    }
}

/// A deterministic source of mutations.
struct Mutator<'l> {
    state: u64,
    layout: &'l Layout,
}

impl Mutator<'_> {
    fn random(&mut self) -> u64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        self.state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16
    }

    fn below(&mut self, n: usize) -> usize {
        (self.random() % n.max(1) as u64) as usize
    }

    fn mutate(&mut self, valid: &[u8]) -> Vec<u8> {
        let mut bytes = valid.to_vec();
        if self.below(3) == 0 {
            bytes = self.resized(&bytes);
        }
        for _ in 0..=self.below(4) {
            self.one(&mut bytes);
        }
        if self.below(8) != 0 {
            self.layout.repair(&mut bytes);
        }
        bytes
    }

    fn one(&mut self, bytes: &mut Vec<u8>) {
        // Three of four faults go into the sections, because less can go wrong in the header.
        let from = if self.below(4) == 0 { 0 } else { self.layout.header_bytes.min(bytes.len()) };
        let at = from + self.below(bytes.len() - from);
        let word = at & !3;
        if word + 4 > bytes.len() {
            return;
        }
        match self.below(16) {
            0..4 => bytes[at] ^= 1 << self.below(8),
            4..7 => bytes[at] = self.random() as u8,
            7..11 => {
                let near = u32_at(bytes, word);
                let Layout { values, step, .. } = *self.layout;
                let beside = [near.wrapping_add(step), near.wrapping_sub(step)];
                let pick = self.below(values.len() + 2);
                let value = values.get(pick).copied().unwrap_or_else(|| beside[pick - values.len()]);
                put_u32(bytes, word, value);
            }
            11..13 => {
                let other = self.below(bytes.len() / 4) * 4;
                let (a, b) = (u32_at(bytes, word), u32_at(bytes, other));
                put_u32(bytes, word, b);
                if self.below(2) == 0 {
                    put_u32(bytes, other, a);
                }
            }
            13 => put_u32(bytes, word, self.random() as u32),
            14 => bytes.truncate(at),
            _ => {
                let value = self.random() as u8;
                bytes.push(value);
            }
        }
    }

    /// Inserts or removes an element of one section and lays the file out again, so that only the contents
    /// are wrong.
    fn resized(&mut self, bytes: &[u8]) -> Vec<u8> {
        let table = self.layout.table;
        let mut sections = [0, 1, 2].map(|i| {
            let (from, length) =
                (u64_at(bytes, table + i * ROW) as usize, u64_at(bytes, table + i * ROW + 8) as usize);
            bytes[from..from + length].to_vec()
        });
        let (which, element) = self.layout.resizable[self.below(2)];
        let section = &mut sections[which];
        let at = self.below(section.len() / element + 1) * element;
        if self.below(2) == 0 {
            let fresh = self.random().to_le_bytes();
            section.splice(at..at, fresh.into_iter().cycle().take(element));
        } else if at < section.len() {
            section.drain(at..at + element);
        }
        let mut out = bytes[..self.layout.header_bytes].to_vec();
        for (i, section) in sections.iter().enumerate() {
            out.resize(out.len().next_multiple_of(16), 0);
            let (offset, length) = (out.len() as u64, section.len() as u64);
            out[table + i * ROW..][..8].copy_from_slice(&offset.to_le_bytes());
            out[table + i * ROW + 8..][..8].copy_from_slice(&length.to_le_bytes());
            out.extend_from_slice(section);
        }
        self.layout.repair(&mut out);
        out
    }
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight bytes"))
}

fn put_u32(bytes: &mut [u8], at: usize, value: u32) {
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
}
