//! Looks up the visibility of a voxel directly in the bytes.
//!
//! The path to a voxel is a number with three bits per level. The mirror of a pointer flips these bits in all
//! levels below, which is a single xor. Each level costs two reads, one of a header and one of the bytes of a
//! child.

use crate::tree::symmetric::{SymmetricTree, node};
use crate::tree::word::{Node, Word};

/// The lowest bit of every level of a path.
const EVERY_LEVEL: u64 = 0o111_111_111_111_111;

/// Bit k is set if kind k is a node.
const POINTERS: u32 = 0b1111_0100;
/// By kind: mask of the bits that belong to the child, out of the next four bytes.
const VALUE: [u32; 8] = [0, 0, 0, 0xff, 0xff, 0xffff, 0xff_ffff, !0];
/// By kind, as masks: whether addresses count from the end of the node
/// (`NEXT`) or the end of the pointer (`NEAR`), else from 0.
const NEXT: [u32; 8] = [0, 0, !0, 0, 0, 0, 0, 0];
const NEAR: [u32; 8] = [0, 0, 0, 0, !0, 0, 0, 0];
/// By kind, with mirrors: mask of the mirror bits.
const MIRROR: [u32; 8] = [0, 0, 0, 0, 0, 0, 7, 7];
const SHIFT: [u32; 8] = [0, 0, 0, 0, 0, 0, 3, 3];

/// Spreads the bits of a coordinate three apart.
fn spread(coordinate: u32) -> u64 {
    let c = u64::from(coordinate & 0x7fff);
    let c = (c | c << 16) & 0x0000_0000_ff00_00ff;
    let c = (c | c << 8) & 0x0000_00f0_0f00_f00f;
    let c = (c | c << 4) & 0x0000_0c30_c30c_30c3;
    (c | c << 2) & EVERY_LEVEL
}

impl SymmetricTree {
    /// Returns the visibility of voxel (x, y, z), each coordinate below 2^depth.
    pub fn voxel(&self, xyz: [u32; 3]) -> bool {
        self.find(xyz).0
    }

    /// Returns the visibility of voxel (x, y, z) and the level of the cube that determines it: 0 = a single
    /// voxel.
    pub fn find(&self, xyz: [u32; 3]) -> (bool, u32) {
        if self.mirrors { self.descend::<true>(xyz) } else { self.descend::<false>(xyz) }
    }

    fn descend<const MIRRORS: bool>(&self, xyz: [u32; 3]) -> (bool, u32) {
        let bytes = &self.bytes[..];
        let mut path = spread(xyz[0]) << 2 | spread(xyz[1]) << 1 | spread(xyz[2]);
        let mut level = self.depth;
        let mut at = match Word(node::word_at(bytes, 4)).node() {
            Node::Uniform(lit) => return (lit, level),
            Node::Mask(mask) => return (mask >> (path >> (3 * (level - 1)) & 7) & 1 == 1, level - 1),
            Node::Inner(at) => at,
        };
        while level > 0 {
            level -= 1;
            let child = (path >> (3 * level) & 7) as u32;
            let header = node::header_at(bytes, at);
            let here = at + node::HEADER_BYTES + node::bytes_before(header, child);
            let value = node::word_at(bytes, here);
            let kind = node::kind(header, child);
            if POINTERS >> kind & 1 == 0 {
                if kind != node::MASK {
                    return (kind == node::LIT, level);
                }
                level = level.saturating_sub(1);
                return (value >> (path >> (3 * level) & 7) & 1 == 1, level);
            }
            // The kind of pointer is hard to predict, so there is no branch on it.
            let k = kind as usize;
            let value = value & VALUE[k];
            let end = at + node::HEADER_BYTES + node::children_bytes(header);
            let from = end & NEXT[k] | (here + 1) & NEAR[k];
            if MIRRORS {
                path ^= u64::from(value & MIRROR[k]) * EVERY_LEVEL;
                at = from + (value >> SHIFT[k]);
            } else {
                at = from + value;
            }
        }
        // Unreachable for checked bytes.
        (false, 0)
    }
}
