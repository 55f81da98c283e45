//! Code shared by the quick test and the fuzz target: damages a tree file, corrects its checksums, and checks
//! that the reader either refuses it or gives a tree that can be looked up everywhere.

#[path = "../format_damage/mod.rs"]
mod format_damage;

use adumbra_papers::tree::{TREE_HEADER_BYTES, TreeBody, TreeFile, TreeFileError, Voxels, leaf_voxels};
use format_damage::Layout;

/// Blocks are words of the body; an attribute has one byte per leaf voxel.
pub(crate) const LAYOUT: Layout = Layout {
    header_bytes: TREE_HEADER_BYTES,
    table: 224,
    resizable: [(1, 4), (2, 1)],
    values: &[0, 1, 9, 17, 0x8000_0000, 0x8000_0001, 0xC000_0000, 0xC000_0033, 0xC000_00FF],
    step: 8,
};

/// Reads `bytes`. A file that is accepted must be written as exactly the same bytes, in one piece or in two,
/// and must be usable for look-ups.
///
/// # Panics
/// Panics if the library is wrong.
pub(crate) fn exercise(bytes: &[u8]) -> Result<TreeFile, TreeFileError> {
    let file = TreeFile::from_bytes(bytes);
    match &file {
        Ok(file) => {
            assert_eq!(file.encode(), bytes, "an accepted file is the only one with its contents");
            assert_eq!(file.encoded_len(), bytes.len() as u64);
            file.check().expect("what was read can be written");
            match &file.body {
                TreeBody::Words(tree) => {
                    let rest = file.without_words().expect("words");
                    let again = TreeFile::with_words(&rest, tree.words()).expect("the same words");
                    assert_eq!(again.encode(), bytes);
                    assert!(file.attribute.is_empty() || file.attribute.len() as u64 == leaf_voxels(tree));
                    sweep(tree, tree.side(), 512);
                }
                TreeBody::Symmetric(tree) => {
                    assert!(file.without_words().is_none());
                    sweep(tree, 1 << tree.depth(), 512);
                }
            }
        }
        // Formatting the message must not fail either.
        Err(error) => assert!(!error.to_string().is_empty() && !error.kind().is_empty()),
    }
    file
}

/// Looks up roughly `most` voxels at most, or every voxel if there are no more than that; returns how many
/// are lit.
pub(crate) fn sweep(tree: &impl Voxels, side: u32, most: u64) -> u64 {
    let side = u64::from(side);
    let all = side * side * side;
    let step = usize::try_from(all.div_ceil(most).max(1) | 1).expect("64 bits");
    let voxels =
        (0..all).step_by(step).map(|i| [i % side, i / side % side, i / side / side].map(|c| c as u32));
    voxels.map(|v| u64::from(tree.voxel(v))).sum()
}
