//! What the quick test and the fuzz target do to a tree file: break it, make the checksums right again, and see that
//! the reader either refuses it or gives a tree that answers everywhere.

#[path = "../format_support/damage.rs"]
mod damage;

use adumbra::format::tree::TREE_HEADER_BYTES;
use adumbra::format::{FormatError, TreeBody, TreeFile};
use adumbra::tree::{Voxels, leaf_voxels};
use damage::Layout;

/// Blocks are words of the body; an attribute has a byte a leaf voxel.
const LAYOUT: Layout = Layout {
    header_bytes: TREE_HEADER_BYTES,
    table: 224,
    resizable: [(1, 4), (2, 1)],
    values: &[0, 1, 9, 17, 0x8000_0000, 0x8000_0001, 0xC000_0000, 0xC000_0033, 0xC000_00FF],
    step: 8,
};

/// The bytes that a fuzzer's input stands for, see [`damage::interpret`].
pub(crate) fn interpret(input: &[u8]) -> Vec<u8> {
    damage::interpret(input, &LAYOUT)
}

/// A deterministic source of mutations.
pub(crate) struct Mutator(damage::Mutator);

impl Mutator {
    pub(crate) fn new(seed: u64) -> Self {
        Self(damage::Mutator::new(seed, LAYOUT))
    }

    pub(crate) fn mutate(&mut self, valid: &[u8]) -> Vec<u8> {
        self.0.mutate(valid)
    }
}

/// Reads `bytes`; a file that is accepted must be written as the very same bytes, in one piece or in two, and must
/// answer.
///
/// # Panics
/// When the library is wrong.
pub(crate) fn exercise(bytes: &[u8]) -> Result<TreeFile, FormatError> {
    let file = TreeFile::parse(bytes);
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
        // A message must not fail either.
        Err(error) => assert!(!error.to_string().is_empty() && !error.kind().is_empty()),
    }
    file
}

/// Looks up to about `most` voxels up, every one where there are so few; returns how many are lit.
pub(crate) fn sweep(tree: &impl Voxels, side: u32, most: u64) -> u64 {
    let side = u64::from(side);
    let all = side * side * side;
    let step = usize::try_from(all.div_ceil(most).max(1) | 1).expect("64 bits");
    let voxels =
        (0..all).step_by(step).map(|i| [i % side, i / side % side, i / side / side].map(|c| c as u32));
    voxels.map(|v| u64::from(tree.voxel(v))).sum()
}
