//! The encoding of a node: a header of three bytes, followed by the bytes of its children, child 0 first.
//!
//! The kind of child i is bits 3i + 2 to 3i of the header:
//!
//! | kind | bits | bytes | the child |
//! |---|---|---|---|
//! | 0 | 000 | 0 | shadowed |
//! | 1 | 001 | 0 | lit |
//! | 2 | 010 | 0 | the node that begins where this one ends |
//! | 3 | 011 | 1 | a leaf of eight, bit i = child i is lit |
//! | 4 | 100 | 1 | the node that begins this many bytes after this byte |
//! | 5 | 101 | 2 | the node at this address |
//! | 6 | 110 | 3 | the node at this address, with mirrors in the low three bits |
//! | 7 | 111 | 4 | the node at this address, with mirrors in the low three bits |
//!
//! Addresses are byte offsets from the start of the body, little-endian. In kinds 6 and 7 of a tree with
//! mirrors, bits 2, 1, 0 of the value are the mirror along x, y, z and the rest is the address. Without
//! mirrors, all bits are the address. Worked value: lit, mask 0x0f, the node at 0x1234, five shadowed: kinds
//! 1, 3, 5, 0 … give the header `59 01 00`, then `0f`, then `34 12`.

/// Bytes of a header.
pub(crate) const HEADER_BYTES: u32 = 3;
/// All voxels shadowed.
pub(crate) const SHADOWED: u32 = 0;
/// All voxels lit.
pub(crate) const LIT: u32 = 1;
/// The node that follows this one.
pub(crate) const NEXT: u32 = 2;
/// A leaf of eight.
pub(crate) const MASK: u32 = 3;
/// A node a few bytes ahead.
pub(crate) const NEAR: u32 = 4;
/// A two-byte address.
pub(crate) const SHORT: u32 = 5;
/// A three-byte address; the next kind has four bytes.
pub(crate) const LONG: u32 = 6;

/// A decoded child.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Child {
    /// Every voxel has this visibility.
    Uniform(bool),
    /// Eight voxels, or larger cells.
    Mask(u8),
    /// The node at an address, under a mirror.
    Node {
        /// Address.
        at: u32,
        /// Mirrored along x (4), y (2), z (1).
        mirror: u8,
    },
}

/// Bytes of a child by kind.
const BYTES: [u8; 8] = [0, 0, 0, 1, 1, 2, 3, 4];

/// Total bytes of four children, by their twelve bits of the header. Two table reads replace a population
/// count, which is slower on processors without an instruction for it.
static FOUR_CHILDREN: [u8; 4096] = {
    let mut sums = [0; 4096];
    let mut kinds = 0;
    while kinds < sums.len() {
        sums[kinds] =
            BYTES[kinds & 7] + BYTES[kinds >> 3 & 7] + BYTES[kinds >> 6 & 7] + BYTES[kinds >> 9 & 7];
        kinds += 1;
    }
    sums
};

/// Returns the header of a node whose children are of these kinds.
pub(crate) fn header(kinds: [u32; 8]) -> u32 {
    kinds.into_iter().rev().fold(0, |h, kind| h << 3 | kind)
}

/// Returns the kind of child i.
pub(crate) fn kind(header: u32, i: u32) -> u32 {
    header >> (3 * i) & 7
}

/// Returns the total bytes of all children in the header.
pub(crate) fn children_bytes(header: u32) -> u32 {
    let four = |kinds: u32| u32::from(FOUR_CHILDREN[(kinds & 0xfff) as usize]);
    four(header) + four(header >> 12)
}

/// Returns the total bytes of the children before child i.
pub(crate) fn bytes_before(header: u32, i: u32) -> u32 {
    children_bytes(header & ((1 << (3 * i)) - 1))
}

/// Returns the 32 bits at an address, little-endian, or 0 outside the bytes.
pub(crate) fn word_at(bytes: &[u8], at: u32) -> u32 {
    let at = at as usize;
    match bytes.get(at..).and_then(|b| b.first_chunk()) {
        Some(four) => u32::from_le_bytes(*four),
        None => 0,
    }
}

/// Returns the header of the node at an address.
pub(crate) fn header_at(bytes: &[u8], at: u32) -> u32 {
    word_at(bytes, at) & 0xff_ffff
}

/// Decodes child i of the node at `at`.
pub(crate) fn child_at(bytes: &[u8], mirrors: bool, at: u32, i: u32) -> Child {
    let header = header_at(bytes, at);
    let here = at + HEADER_BYTES + bytes_before(header, i);
    let value = word_at(bytes, here);
    let addressed = |value: u32| {
        if mirrors {
            Child::Node { at: value >> 3, mirror: (value & 7) as u8 }
        } else {
            Child::Node { at: value, mirror: 0 }
        }
    };
    match kind(header, i) {
        SHADOWED => Child::Uniform(false),
        LIT => Child::Uniform(true),
        NEXT => Child::Node { at: at + HEADER_BYTES + children_bytes(header), mirror: 0 },
        MASK => Child::Mask(value as u8),
        NEAR => Child::Node { at: here + 1 + (value & 0xff), mirror: 0 },
        SHORT => Child::Node { at: value & 0xffff, mirror: 0 },
        LONG => addressed(value & 0xff_ffff),
        _ => addressed(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symmetric_node_worked_value() {
        let header = header([LIT, MASK, SHORT, 0, 0, 0, 0, 0]);
        assert_eq!(header.to_le_bytes(), [0x59, 0x01, 0x00, 0]);
        assert_eq!(children_bytes(header), 3);
        let bytes = [0x59, 0x01, 0x00, 0x0f, 0x34, 0x12, 0, 0, 0, 0];
        let child = |i| child_at(&bytes, true, 0, i);
        assert_eq!(child(0), Child::Uniform(true));
        assert_eq!(child(1), Child::Mask(0x0f));
        assert_eq!(child(2), Child::Node { at: 0x1234, mirror: 0 });
        assert_eq!(child(3), Child::Uniform(false));
    }

    /// The method of the specification, for shaders.
    fn counted(header: u32) -> u32 {
        let [one, two, four] = [0, 1, 2].map(|bit| header >> bit & 0o1111_1111);
        (four | (one & (two | four)) << 1 | (two & four) << 2).count_ones() + (two & four).count_ones()
    }

    #[test]
    fn symmetric_node_sizes_of_every_kind() {
        let all = header([0, 1, 2, 3, 4, 5, 6, 7]);
        for i in 0..8 {
            assert_eq!(kind(all, i), i);
            assert_eq!(bytes_before(all, i), BYTES[..i as usize].iter().map(|&b| u32::from(b)).sum::<u32>());
            assert_eq!(counted(all & ((1 << (3 * i)) - 1)), bytes_before(all, i));
            assert_eq!(children_bytes(header([i; 8])), 8 * u32::from(BYTES[i as usize]));
        }
    }
}
