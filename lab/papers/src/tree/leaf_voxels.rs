//! Counts the voxels of the leaves of eight: the voxels at shadow borders, which an attribute has one byte
//! each for.

use crate::tree::graph::VoxelTree;
use crate::tree::word::Node;

const UNSEEN: u64 = u64::MAX;

/// Returns the number of voxels of the leaves of eight in the expanded tree: eight per leaf, and a block with
/// several parents counts for each of them. A leaf of eight above the lowest level has larger cells; each of
/// them counts as one.
///
/// Cost: one walk over the graph, eight bytes per block.
pub fn leaf_voxels(tree: &VoxelTree) -> u64 {
    count(tree, 0, &mut vec![UNSEEN; tree.words().len() / 8])
}

/// Recurses as deep as the tree has levels, at most 15, so no sum exceeds 2^45.
fn count(tree: &VoxelTree, word: u32, blocks: &mut [u64]) -> u64 {
    match tree.node(word) {
        Node::Uniform(_) => 0,
        Node::Mask(_) => 8,
        Node::Inner(first) => {
            let block = first as usize / 8;
            if blocks[block] == UNSEEN {
                blocks[block] = (0..8).map(|child| count(tree, first + child, blocks)).sum();
            }
            blocks[block]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::word::Word;

    #[test]
    fn leaf_voxels_count_a_shared_block_for_each_parent() {
        let (lit, mask) = (Word::LIT.0, Word::leaf(0x5a).0);
        let one = |word| VoxelTree::from_words(4, vec![word]).unwrap();
        assert_eq!((leaf_voxels(&one(lit)), leaf_voxels(&one(mask))), (0, 8));
        // The second block, with two leaves of eight, has three parents.
        let words = [
            vec![1],
            vec![9, 9, lit, mask, lit, 9, lit, lit],
            vec![mask, mask, lit, lit, lit, lit, lit, lit],
        ];
        assert_eq!(leaf_voxels(&VoxelTree::from_words(4, words.concat()).unwrap()), 8 * (3 * 2 + 1));
    }

    #[test]
    fn leaf_voxels_of_largest_tree_do_not_overflow() {
        let block = |next: u32| [next; 8];
        let mut words = vec![1];
        for level in 1..14_u32 {
            words.extend(block(1 + 8 * level));
        }
        words.extend(block(Word::leaf(1).0));
        assert_eq!(leaf_voxels(&VoxelTree::from_words(15, words).unwrap()), 1 << 45);
    }
}
