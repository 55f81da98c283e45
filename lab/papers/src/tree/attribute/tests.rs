//! Compares values found through the graph with values found in the tree that the graph was made from.

use crate::tree::attribute::*;
use crate::tree::build::TreeBuilder;
use crate::tree::kit::{all_voxels, noisy_spaces};
use crate::tree::lossy;
use crate::tree::reduce::sort;
use crate::tree::word::Word;
use adumbra_bake::Error as BakeError;
use adumbra_scene::random::mix;
use proptest::prelude::*;

/// A value that differs between almost all cells.
fn by_position(xyz: [u32; 3], level: u32) -> u8 {
    (mix(u64::from(xyz[0]) << 42 | u64::from(xyz[1]) << 21 | u64::from(xyz[2])) >> 13) as u8 ^ level as u8
}

/// Returns the lowest voxel and the level of the cell, within a leaf of eight, that contains a voxel; `None`
/// in a uniform leaf. Uses the words only.
fn cell(tree: &VoxelTree, xyz: [u32; 3]) -> Option<([u32; 3], u32)> {
    let (mut node, mut level) = (tree.node(0), tree.depth());
    loop {
        level = level.checked_sub(1)?;
        match node {
            Node::Uniform(_) => return None,
            Node::Mask(_) => return Some((xyz.map(|c| c >> level << level), level)),
            Node::Inner(first) => node = tree.node(first + morton::child(xyz, level)),
        }
    }
}

proptest! {
    #[test]
    fn attributes_are_equal_in_tree_and_reduced_graph(space in noisy_spaces()) {
        let whole = TreeBuilder::Recursive.tree(&space, space.depth, true).unwrap();
        let graph = sort(whole.clone()).0.number(space.depth);
        let whole = whole.number(space.depth);
        let [in_whole, in_graph] = [&whole, &graph].map(|t| AttributeIndex::of(t).unwrap());
        let values = gather(&whole, &in_whole, &by_position);
        // The expanded trees are identical, so the values are too.
        prop_assert_eq!(&gather(&graph, &in_graph, &by_position), &values);
        prop_assert_eq!(in_graph.leaf_voxels(), leaf_voxels(&graph));
        prop_assert_eq!(values.len() as u64, in_graph.leaf_voxels());
        let mut cells = vec![None; values.len()];
        for xyz in all_voxels(space.depth) {
            let index = in_graph.locate(&graph, xyz);
            prop_assert_eq!(index, in_whole.locate(&whole, xyz));
            prop_assert_eq!(index.is_some(), cell(&whole, xyz).is_some());
            let (Some(i), Some((corner, level))) = (index, cell(&whole, xyz)) else { continue };
            prop_assert_eq!(values[i as usize], by_position(corner, level));
            // Cells and indices correspond one to one.
            prop_assert_eq!(*cells[i as usize].get_or_insert((corner, level)), (corner, level));
        }
        prop_assert!(cells.iter().all(Option::is_some));
        let mut distinct: Vec<_> = cells.into_iter().flatten().collect();
        distinct.sort_unstable();
        distinct.dedup();
        prop_assert_eq!(distinct.len(), values.len());
    }

    #[test]
    fn attributes_match_leaf_voxels_of_lossy_graph(space in noisy_spaces(), share in 0.0..0.5_f64) {
        let graph = sort(TreeBuilder::Pooled.tree(&space, space.depth, true).unwrap()).0.number(space.depth);
        let graph = lossy::merge_similar(&graph, share).unwrap().tree;
        let index = AttributeIndex::of(&graph).unwrap();
        let values = gather(&graph, &index, &by_position);
        for xyz in all_voxels(space.depth) {
            let found = index.locate(&graph, xyz).map(|i| values[i as usize]);
            prop_assert_eq!(found, cell(&graph, xyz).map(|(corner, level)| by_position(corner, level)));
        }
    }
}

/// A chain of shared blocks over `depth` levels: eight children each, every leaf the same.
fn repeated(depth: u32) -> VoxelTree {
    let mut words = vec![1];
    for block in 1..depth {
        words.extend([if block + 1 < depth { 1 + 8 * block } else { Word::leaf(0x17).0 }; 8]);
    }
    VoxelTree::from_words(depth, words).unwrap()
}

#[test]
fn attribute_worked_value() {
    // Depth 2: child 0 is lit, children 1 and 6 are leaves of eight.
    let mut words = vec![1];
    words.extend([Word::LIT.0; 8]);
    (words[2], words[7]) = (Word::leaf(3).0, Word::leaf(5).0);
    let tree = VoxelTree::from_words(2, words).unwrap();
    let index = AttributeIndex::of(&tree).unwrap();
    assert_eq!(index.leaf_voxels(), 16);
    assert_eq!(index.memory_bytes(), 9 * 4);
    assert_eq!(index.locate(&tree, [0, 0, 0]), None);
    // Path 1, 5: the sixth value.
    assert_eq!(index.locate(&tree, [1, 0, 3]), Some(5));
    // Path 6, 0: the first value after the eight of child 1.
    assert_eq!(index.locate(&tree, [2, 2, 0]), Some(8));
    let values = gather(&tree, &index, &|[x, y, z], level| (x << 4 | y << 2 | z | level << 6) as u8);
    assert_eq!((values[5], values[8]), (0b01_00_11, 0b10_10_00));
}

#[test]
fn attributes_refuse_more_leaf_voxels_than_32_bits_count() {
    assert_eq!(AttributeIndex::of(&repeated(10)).unwrap().leaf_voxels(), 1 << 30);
    let refused = AttributeIndex::of(&repeated(11));
    assert!(
        matches!(refused, Err(Error::Bake(BakeError::MemoryLimit { needed_bytes, .. })) if needed_bytes == 1 << 33)
    );
}

#[test]
fn attribute_values_do_not_depend_on_threads() {
    let tree = repeated(6);
    let index = AttributeIndex::of(&tree).unwrap();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| gather(&tree, &index, &by_position))
    };
    let one = on(1);
    assert_eq!(one.len(), 1 << 18);
    assert_eq!(one, on(5));
    for xyz in [[0, 0, 0], [17, 40, 63], [63, 63, 63]] {
        let at = index.locate(&tree, xyz).unwrap();
        assert_eq!(one[at as usize], by_position(xyz, 0));
    }
}

#[test]
fn attributes_do_not_panic_with_index_of_another_tree() {
    let (small, large) = (repeated(2), repeated(4));
    let [of_small, of_large] = [&small, &large].map(|t| AttributeIndex::of(t).unwrap());
    assert_eq!(gather(&large, &of_small, &by_position).len(), 64);
    assert_eq!(gather(&small, &of_large, &by_position).len(), 4096);
    assert_eq!(of_small.locate(&large, [15, 15, 15]), None);
}
