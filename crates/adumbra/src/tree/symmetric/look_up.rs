//! A voxel's visibility straight from the bytes.
//!
//! The path to a voxel is one number of three bits a level. A pointer's mirror flips them in all levels below, which is one
//! xor. A level costs two reads, of a header and of a child's bytes.

use super::SymmetricTree;
use super::node;
use crate::tree::word::{Node, Word};

/// Bit 0 of every level of a path.
const EVERY_LEVEL: u64 = 0o111_111_111_111_111;

/// Bit k is set where kind k is a node.
const POINTERS: u32 = 0b1111_0100;
/// By kind: the bits of the next four bytes that are the child's.
const VALUE: [u32; 8] = [0, 0, 0, 0xff, 0xff, 0xffff, 0xff_ffff, !0];
/// By kind: what addresses count from: nothing, the node's end, the pointer's end.
const NEXT: [u32; 8] = [0, 0, !0, 0, 0, 0, 0, 0];
const NEAR: [u32; 8] = [0, 0, 0, 0, !0, 0, 0, 0];
/// By kind, with mirrors: their bits.
const MIRROR: [u32; 8] = [0, 0, 0, 0, 0, 0, 7, 7];
const SHIFT: [u32; 8] = [0, 0, 0, 0, 0, 0, 3, 3];

/// Bits of a coordinate, three apart.
fn spread(coordinate: u32) -> u64 {
    let c = u64::from(coordinate & 0x7fff);
    let c = (c | c << 16) & 0x0000_0000_ff00_00ff;
    let c = (c | c << 8) & 0x0000_00f0_0f00_f00f;
    let c = (c | c << 4) & 0x0000_0c30_c30c_30c3;
    (c | c << 2) & EVERY_LEVEL
}

impl SymmetricTree {
    /// Visibility of voxel (x, y, z), each below 2^depth.
    pub fn voxel(&self, xyz: [u32; 3]) -> bool {
        self.find(xyz).0
    }

    /// Visibility of voxel (x, y, z) and the level of the leaf that says so: 0 = a voxel.
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
            // Which kind of pointer is hard to foretell, so none is branched on.
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
        // Checked bytes do not lead here.
        (false, 0)
    }
}
