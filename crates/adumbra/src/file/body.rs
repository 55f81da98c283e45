//! The sections of a file's voxels: their lengths, their bytes and back.

use crate::file::header::{HEADER_BYTES, Header};
use crate::file::sections::{lay_out, u32_chunks, u32_words};
use crate::layout::depths::DepthTree;

/// Number of roots along x, y and z as the header has them.
pub(super) fn top_dims(tree: &DepthTree) -> [u32; 3] {
    crate::layout::top_dims(tree.size, tree.root_level)
}

/// Returns the sizes of the sections in bytes: top, nodes, leaf masks.
pub(super) fn section_lengths(tree: &DepthTree) -> [u64; 3] {
    [tree.top.len() * 8, tree.code.len() * 4, tree.wide.len() * 8].map(|bytes| bytes as u64)
}

/// Returns the size in bytes of a file with these voxels.
pub(super) fn encoded_len(tree: &DepthTree) -> u64 {
    lay_out(HEADER_BYTES, section_lengths(tree))[2].end()
}

/// Returns the bytes of a section, in pieces of some 64 KiB.
pub(super) fn chunks(tree: &DepthTree, section: usize) -> impl Iterator<Item = Vec<u8>> + '_ {
    u32_chunks(match section {
        0 => tree.top.as_flattened(),
        1 => &tree.code,
        _ => tree.wide.as_flattened(),
    })
}

/// Decodes the sections without validating them.
pub(super) fn parse(header: &Header, [top, code, wide]: [&[u8]; 3]) -> DepthTree {
    DepthTree {
        size: header.grid.size,
        root_level: header.root_level,
        top_dims: [header.top_dims[0], header.top_dims[1]],
        top: u32_words(top).as_chunks().0.to_vec(),
        wide: u32_words(wide).as_chunks().0.to_vec(),
        code: u32_words(code),
    }
}
