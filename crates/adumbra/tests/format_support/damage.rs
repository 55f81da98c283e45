//! Damages shadow files, and repairs their checksums.

/// Size of the header, of a directory entry and of a table's entry in bytes.
const HEADER: usize = 256;
const GRID: usize = 256;
const ROW: usize = 24;
/// Offsets of fields of the header.
const ENCODING: usize = 28;
const FILE_BYTES: usize = 136;

/// Words that have a special meaning somewhere in a file.
const VALUES: [u32; 10] = [0, 1, 0x0041, 0x5555, 0x8000, 0x8003, 0xAAAA, 0xFFFF, 0x8000_0000, u32::MAX];

/// Returns the bytes that a fuzzer's input represents. If the first byte is odd (as in `A`), the input is the
/// file as it is. If it is even (as in `@`), the file begins with `A` instead, and its checksums are
/// repaired.
pub(crate) fn interpret(input: &[u8]) -> Vec<u8> {
    let mut bytes = input.to_vec();
    if let Some(first) = bytes.first_mut()
        && *first & 1 == 0
    {
        *first = b'A';
        repair(&mut bytes);
    }
    bytes
}

/// Returns `valid` with one to four faults that follow from `seed`. In most cases the checksums are repaired,
/// in some a bundle or the common section is resized.
pub(crate) fn mutate(valid: &[u8], seed: u64) -> Vec<u8> {
    Mutator { state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1 }.mutate(valid)
}

/// Returns offset and length of a section of a level, 0 = table, 1 = common section, 2 = bundles. `None` if
/// it is not in the file.
fn section(bytes: &[u8], level: usize, section: usize) -> Option<[usize; 2]> {
    let at = HEADER + GRID * level + 160 + 24 * section;
    let entry = bytes.get(at..at + 16)?;
    let [from, length] = [0, 8].map(|i| u64_at(entry, i));
    let end = from.checked_add(length).filter(|&end| end <= bytes.len() as u64)?;
    Some([from as usize, (end - from) as usize])
}

/// Repairs all checksums of parts that are within the file.
fn repair(bytes: &mut [u8]) {
    if bytes.len() < HEADER {
        return;
    }
    let levels = (u32_at(bytes, 24) as usize).min((bytes.len() - HEADER) / GRID);
    for level in 0..levels {
        if let (Some([table, length]), Some([mut at, _])) =
            (section(bytes, level, 0), section(bytes, level, 2))
        {
            for row in (table..table + length / ROW * ROW).step_by(ROW) {
                let stored = u32_at(bytes, row) as usize;
                let Some(bundle) = at.checked_add(stored).and_then(|end| bytes.get(at..end)) else { break };
                let checksum = if stored == 0 { 0 } else { crc32fast::hash(bundle) };
                put_u32(bytes, row + 8, checksum);
                at += stored;
            }
        }
        for part in [0, 1] {
            if let Some([from, length]) = section(bytes, level, part) {
                let checksum = crc32fast::hash(&bytes[from..from + length]);
                put_u32(bytes, HEADER + GRID * level + 176 + 24 * part, checksum);
            }
        }
    }
    let directory = crc32fast::hash(&bytes[HEADER..HEADER + GRID * levels]);
    put_u32(bytes, 132, directory);
    let checksum = crc32fast::hash(&bytes[..HEADER - 4]);
    put_u32(bytes, HEADER - 4, checksum);
}

/// A deterministic source of mutations.
struct Mutator {
    state: u64,
}

impl Mutator {
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
            repair(&mut bytes);
        }
        bytes
    }

    fn one(&mut self, bytes: &mut Vec<u8>) {
        // Half of the faults go into the words of pages, where most can go wrong.
        let code = section(bytes, 0, 2).map_or(0, |[from, length]| from + length.min(192));
        let from = [0, HEADER + GRID, code, code][self.below(4)].min(bytes.len());
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
                let beside = [near.wrapping_add(1), near.wrapping_sub(1)];
                let pick = self.below(VALUES.len() + 2);
                let value = VALUES.get(pick).copied().unwrap_or_else(|| beside[pick - VALUES.len()]);
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

    /// Inserts or removes a word of the finest level's first page with words, and lays the file out again, so
    /// that only the page is wrong. In a coded file it is a byte of the first bundle with bytes.
    fn resized(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut out = bytes.to_vec();
        let (Some([table, length]), Some([mut at, _])) = (section(bytes, 0, 0), section(bytes, 0, 2)) else {
            return out;
        };
        let rows = (table..table + length).step_by(ROW);
        let Some(row) = rows.clone().find(|&row| u32_at(bytes, row) > 0) else { return out };
        at += rows.take_while(|&before| before < row).map(|row| u32_at(bytes, row) as usize).sum::<usize>();
        if u32_at(bytes, ENCODING) != 0 {
            let byte = at + self.below(u32_at(bytes, row) as usize);
            let step = if self.below(2) == 0 {
                out.insert(byte, self.random() as u8);
                1
            } else {
                out.remove(byte);
                u32::MAX
            };
            for place in [row, HEADER + 216, FILE_BYTES] {
                put_u32(&mut out, place, u32_at(bytes, place).wrapping_add(step));
            }
            repair(&mut out);
            return out;
        }
        let Some(slot) = (0..16).find(|slot| u32_at(bytes, at + 12 * slot + 8) > 0) else { return out };
        let words = u32_at(bytes, at + 12 * slot + 8);
        let before: u32 = (0..slot).map(|slot| u32_at(bytes, at + 12 * slot + 8)).sum();
        let word = at + 192 + 4 * (before as usize + self.below(words as usize));
        let step = if self.below(2) == 0 {
            out.splice(word..word, (self.random() as u32).to_le_bytes());
            1
        } else {
            out.drain(word..word + 4);
            u32::MAX
        };
        let mut add = |at: usize, by: u32| put_u32(&mut out, at, u32_at(bytes, at).wrapping_add(by));
        add(at + 12 * slot + 8, step);
        for place in [row, row + 4, HEADER + 216, FILE_BYTES] {
            add(place, step.wrapping_mul(4));
        }
        repair(&mut out);
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
