//! Distinguishes frequent hashes from rare ones in a few bits per hash: a table of small counters, of which
//! each hash has two. Hashes that share a cell count together, so a rare hash may seem frequent, but a
//! frequent hash never seems rare.
//!
//! Source: Graham Cormode and S. Muthukrishnan, *An improved data stream summary: the count-min sketch and
//! its applications* (2005), with one table for both rows.

use std::sync::atomic::{AtomicU8, Ordering};

/// Counters for each hash that is expected. With four, at most one hash in a hundred that came once seems to
/// have come three times.
const CELLS_PER_HASH: u64 = 4;
const BITS: u32 = 2;
const CELLS_PER_BYTE: u64 = (u8::BITS / BITS) as u64;
/// The value at which a counter saturates.
pub(super) const OFTEN: usize = (1 << BITS) - 1;

/// Counters of hashes, each up to [`OFTEN`].
///
/// Counters are bits 2i and 2i + 1 of a byte. After the cells 1, 2, 2, 3, 3, 3 byte 0 is `0b11_10_01_00` =
/// 0xe4.
pub(super) struct Sketch(Vec<AtomicU8>);

impl Sketch {
    pub(super) fn new(hashes: u64) -> Self {
        Self((0..Self::bytes(hashes)).map(|_| AtomicU8::new(0)).collect())
    }

    /// Returns the bytes of a sketch for this many hashes.
    pub(super) fn bytes(hashes: u64) -> u64 {
        (CELLS_PER_HASH * hashes.max(1)).next_power_of_two() / CELLS_PER_BYTE
    }

    pub(super) fn count(&self, hash: u128) {
        for (byte, shift) in self.cells(hash) {
            let more = |byte: u8| (!is_full(byte, shift)).then(|| byte + (1 << shift));
            // A full counter does not change.
            let _ = byte.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more);
        }
    }

    /// Whether a hash, with the hashes that share its cells, has been counted [`OFTEN`] times.
    pub(super) fn came_often(&self, hash: u128) -> bool {
        self.cells(hash).iter().all(|&(byte, shift)| is_full(byte.load(Ordering::Relaxed), shift))
    }

    /// Returns the bytes that hold a hash's counters, and the counters' first bits.
    fn cells(&self, hash: u128) -> [(&AtomicU8, u32); 2] {
        [hash as u64, (hash >> 64) as u64].map(|cell| {
            let byte = (cell / CELLS_PER_BYTE) as usize & (self.0.len() - 1);
            (&self.0[byte], BITS * (cell % CELLS_PER_BYTE) as u32)
        })
    }
}

fn is_full(byte: u8, shift: u32) -> bool {
    (byte >> shift) as usize & OFTEN == OFTEN
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_are_packed_in_bytes_and_saturate_at_three() {
        let sketch = Sketch::new(4);
        assert_eq!((sketch.0.len(), Sketch::bytes(4), Sketch::bytes(5)), (4, 4, 8));
        let bytes = || sketch.0.iter().map(|byte| byte.load(Ordering::Relaxed)).collect::<Vec<_>>();
        // Cells of byte 0 by the low half, and of byte 1 by the high one.
        let hash = |cell: u128| (4 + cell) << 64 | cell;
        for cell in [1, 2, 2, 3, 3, 3] {
            sketch.count(hash(cell));
        }
        assert_eq!(bytes(), [0xe4, 0xe4, 0, 0]);
        assert_eq!([0, 1, 2, 3].map(|cell| sketch.came_often(hash(cell))), [false, false, false, true]);
        sketch.count(hash(3));
        // The table wraps after 16 cells.
        sketch.count(8 << 64 | (2 + 16));
        assert_eq!(bytes(), [0xf4, 0xe4, 1, 0]);
        // Both counters must be full.
        assert!(!sketch.came_often(hash(2)) && sketch.came_often(hash(3) + 16) && !sketch.came_often(3));
    }
}
