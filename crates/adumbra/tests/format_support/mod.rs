//! What the quick test and the fuzz target do to a file: break it, make the checksums right again, and see that the
//! reader either refuses it or gives a graph that answers everywhere.

use adumbra::dag::{Dag, LIT, SHADOWED, SLAB_NODE_LEVEL, STATE_LIT, STATE_MIXED, STATE_SHADOWED};
use adumbra::format::{FormatError, HEADER_BYTES, ShadowFile};

/// Where the section table stands, and the bytes of a row.
const TABLE: usize = 280;
const ROW: usize = 24;

/// The bytes that a fuzzer's input stands for. An odd first byte (as `A`): the input is the file, as it is. An even
/// one (as `@`): the file begins with `A` instead, and its checksums are made right.
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

/// Makes the checksums right where the sections lie within the file.
pub(crate) fn repair(bytes: &mut [u8]) {
    if bytes.len() < HEADER_BYTES {
        return;
    }
    for row in [TABLE, TABLE + ROW, TABLE + 2 * ROW] {
        let (from, length) = (u64_at(bytes, row), u64_at(bytes, row + 8));
        let end = from.saturating_add(length).min(usize::MAX as u64);
        if let Some(section) = bytes.get(from as usize..end as usize) {
            let checksum = crc32fast::hash(section);
            put_u32(bytes, row + 16, checksum);
        }
    }
    let checksum = crc32fast::hash(&bytes[..HEADER_BYTES - 4]);
    put_u32(bytes, HEADER_BYTES - 4, checksum);
}

/// Reads `bytes`; a file that is accepted must be written as the very same bytes, and must answer.
///
/// # Panics
/// When the library is wrong.
pub(crate) fn exercise(bytes: &[u8]) -> Result<ShadowFile, FormatError> {
    let file = ShadowFile::from_bytes(bytes);
    match &file {
        Ok(file) => {
            assert_eq!(encode(file), bytes, "an accepted file is the only one with its contents");
            sweep(&file.dag, 512);
        }
        // A message must not fail either.
        Err(error) => assert!(!error.to_string().is_empty() && !error.kind().is_empty()),
    }
    file
}

pub(crate) fn encode(file: &ShadowFile) -> Vec<u8> {
    let mut bytes = Vec::new();
    let written = file.write_to(&mut bytes).expect("a valid file");
    assert_eq!((written, file.encoded_len()), (bytes.len() as u64, bytes.len() as u64));
    bytes
}

/// Looks up to about `most` voxels up, every one where there are so few; returns how many are lit.
pub(crate) fn sweep(dag: &Dag, most: u64) -> u64 {
    let all: u64 = dag.size.iter().map(|&n| u64::from(n)).fold(1, u64::saturating_mul);
    let step = all.div_ceil(most).max(1) | 1;
    let mut lit = 0;
    let mut i = 0_u64;
    while i < all {
        let [sx, sy, _] = dag.size.map(u64::from);
        let v = [(i % sx) as u32, (i / sx % sy) as u32, (i / (sx * sy)) as u32];
        lit += u64::from(is_lit(dag, v));
        let Some(next) = i.checked_add(step) else { break };
        i = next;
    }
    lit
}

/// The answer of a voxel; every index is checked by Rust, and the steps are counted.
pub(crate) fn is_lit(dag: &Dag, [x, y, z]: [u32; 3]) -> bool {
    let [gx, gy, gz] = [x, y, z].map(|c| (c >> dag.root_level) as usize);
    let [dx, dy, _] = dag.top_dims.map(|d| d as usize);
    let mut at = match dag.top[(gz * dy + gy) * dx + gx] {
        LIT => return true,
        SHADOWED => return false,
        root => root as usize,
    };
    for level in (SLAB_NODE_LEVEL..=dag.root_level).rev() {
        let bit = |c: u32| c >> (level - 1) & 1;
        let child = if level == SLAB_NODE_LEVEL { z & 7 } else { bit(x) << 2 | bit(y) << 1 | bit(z) };
        let header = dag.nodes[at];
        match header >> (2 * child) & 3 {
            STATE_SHADOWED => return false,
            STATE_LIT => return true,
            state => assert_eq!(state, STATE_MIXED),
        }
        let before = (header & ((1 << (2 * child)) - 1) & 0xAAAA).count_ones() as usize;
        at = dag.nodes[at + 1 + before] as usize;
    }
    dag.slabs[at] >> ((y & 7) * 8 + (x & 7)) & 1 == 1
}

/// A deterministic source of mutations.
pub(crate) struct Mutator {
    state: u64,
}

impl Mutator {
    pub(crate) fn new(seed: u64) -> Self {
        Self { state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1 }
    }

    fn random(&mut self) -> u64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        self.state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 16
    }

    fn below(&mut self, n: usize) -> usize {
        (self.random() % n.max(1) as u64) as usize
    }

    /// `valid` with one to four faults, in most cases with checksums made right, in some with sections resized.
    pub(crate) fn mutate(&mut self, valid: &[u8]) -> Vec<u8> {
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
        // Three of four faults go into the sections: the header is the smaller part of what can go wrong.
        let from = if self.below(4) == 0 { 0 } else { HEADER_BYTES.min(bytes.len()) };
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
                let values =
                    [0, 1, 0x5555, 0xAAAA, 0xFFFF, LIT, SHADOWED, near.wrapping_add(1), near.wrapping_sub(1)];
                let value = values[self.below(values.len())];
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

    /// Inserts or removes a word of some section and lays the file out anew, so that only the graph is wrong.
    fn resized(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut sections = [0, 1, 2].map(|i| {
            let (from, length) =
                (u64_at(bytes, TABLE + i * ROW) as usize, u64_at(bytes, TABLE + i * ROW + 8) as usize);
            bytes[from..from + length].to_vec()
        });
        let which = 1 + self.below(2);
        let (section, element) = (&mut sections[which], 4 * which);
        let at = self.below(section.len() / element + 1) * element;
        if self.below(2) == 0 {
            let fresh = self.random().to_le_bytes();
            section.splice(at..at, fresh[..element].iter().copied());
        } else if at < section.len() {
            section.drain(at..at + element);
        }
        let mut out = bytes[..HEADER_BYTES].to_vec();
        for (i, section) in sections.iter().enumerate() {
            out.resize(out.len().next_multiple_of(16), 0);
            let (offset, length) = (out.len() as u64, section.len() as u64);
            out[TABLE + i * ROW..][..8].copy_from_slice(&offset.to_le_bytes());
            out[TABLE + i * ROW + 8..][..8].copy_from_slice(&length.to_le_bytes());
            out.extend_from_slice(section);
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
