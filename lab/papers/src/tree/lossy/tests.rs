//! Compares lossy merging with the voxels themselves.

use crate::tree::build::TreeBuilder;
use crate::tree::error::Error;
use crate::tree::kit::{Spelled, all_voxels, noisy_spaces};
use crate::tree::lossy::*;
use crate::tree::morton;
use crate::tree::reduce::{Interned, Sink};
use crate::tree::word::{Node, Word};
use proptest::prelude::*;
use std::collections::HashSet;

fn reduced(space: &Spelled) -> VoxelTree {
    let mut interned = Interned::default();
    let root =
        TreeBuilder::Recursive.build(space, space.depth, false, &mut interned, &|_, _| Ok(())).unwrap();
    interned.finish(root).number(space.depth)
}

fn masks(tree: &VoxelTree) -> HashSet<u8> {
    let mask = |w: &u32| match Word(*w).node() {
        Node::Mask(mask) => Some(mask),
        Node::Inner(_) | Node::Uniform(_) => None,
    };
    tree.words().iter().filter_map(mask).collect()
}

fn differing(a: &VoxelTree, b: &VoxelTree) -> u64 {
    all_voxels(a.depth()).filter(|&xyz| a.voxel(xyz) != b.voxel(xyz)).count() as u64
}

proptest! {
    #[test]
    fn lossy_stays_within_share_and_reports_exact_change(space in noisy_spaces(), share in 0.0..1.0_f64) {
        let tree = reduced(&space);
        let out = merge_similar(&tree, share).unwrap();
        let words = out.tree.words().to_vec();
        prop_assert_eq!(VoxelTree::from_words(space.depth, words), Ok(out.tree.clone()));
        let changed = differing(&tree, &out.tree);
        prop_assert_eq!(out.change.changed_voxels, changed);
        prop_assert_eq!(changed_voxels(&tree, &out.tree), changed);
        prop_assert!(changed as f64 <= share * out.change.leaf_voxels as f64);
        prop_assert_eq!(out.change.max_share, share);
        prop_assert!(out.tree.words().len() as u64 + 8 * out.merged_blocks <= tree.words().len() as u64);
        prop_assert!(masks(&out.tree).is_subset(&masks(&tree)));
        // No block occurs twice.
        let blocks = Blocks::of(&out.tree).blocks;
        prop_assert_eq!(blocks.iter().collect::<HashSet<_>>().len(), blocks.len());
        prop_assert_eq!(merge_similar(&tree, share).unwrap(), out);
    }

    #[test]
    fn leaf_voxels_match_cells_of_leaves_of_eight(space in noisy_spaces()) {
        let tree = reduced(&space);
        let cells = all_voxels(space.depth).filter(|&xyz| {
            let (mut node, mut level) = (tree.node(0), tree.depth());
            while let Node::Inner(first) = node {
                level -= 1;
                node = tree.node(first + morton::child(xyz, level));
            }
            // The lowest voxel of a cell represents it.
            matches!(node, Node::Mask(_)) && xyz.iter().all(|c| c & ((1 << (level - 1)) - 1) == 0)
        });
        prop_assert_eq!(leaf_voxels(&tree), cells.count() as u64);
    }

    #[test]
    fn lossy_with_zero_share_keeps_tree(space in noisy_spaces()) {
        let tree = reduced(&space);
        let out = merge_similar(&tree, 0.0).unwrap();
        prop_assert_eq!(out.change.changed_voxels, 0);
        prop_assert_eq!(out.merged_blocks, 0);
        prop_assert_eq!(out.tree, tree);
    }

    #[test]
    fn changed_voxels_match_comparison_voxel_by_voxel(a in noisy_spaces(), b in noisy_spaces()) {
        let [x, y] = [&a, &b].map(reduced);
        let expected = if a.depth == b.depth { differing(&x, &y) } else { 1 << (3 * a.depth.max(b.depth)) };
        prop_assert_eq!(changed_voxels(&x, &y), expected);
        prop_assert_eq!(changed_voxels(&y, &x), expected);
    }
}

proptest! {
    #[test]
    fn lossy_cost_equals_number_of_differing_voxels(space in noisy_spaces()) {
        let tree = reduced(&space);
        let Blocks { root, blocks } = Blocks::of(&tree);
        let Node::Inner(root) = root.node() else { return Ok(()) };
        let mut facts: Vec<facts::Facts> = Vec::new();
        for words in &blocks {
            let lit = words.iter().map(|w| facts::lit(*w, &facts)).sum::<u64>() / 8;
            facts.push(facts::Facts { single: false, level: 0, saved: 0, lit: lit as u32 });
        }
        let level = space.depth - 1;
        let octant = |c: u32, xyz: [u32; 3]| {
            let offset = morton::child_offset(c);
            tree.voxel(std::array::from_fn(|a| xyz[a] + (offset[a] << level)))
        };
        for (a, b) in (0..8).flat_map(|a| (0..8).map(move |b| (a, b))) {
            let pair = [a, b].map(|c| blocks[root as usize][c as usize]);
            let expected = all_voxels(level).filter(|&xyz| octant(a, xyz) != octant(b, xyz)).count() as u64;
            let cost = |at_most| similar::difference(&blocks, &facts, pair, level, at_most);
            prop_assert_eq!(cost(u64::MAX), expected);
            prop_assert_eq!(cost(expected), expected);
            prop_assert!(expected == 0 || cost(expected - 1) >= expected);
        }
    }
}

/// Depth 3: two blocks of leaves that differ in one voxel; one of them occurs twice.
fn nearly_equal() -> VoxelTree {
    let mut blocks = Interned::default();
    let leaf = |masks: [u8; 8]| masks.map(Word::leaf);
    let often = blocks.block(&leaf([0xf0, 0xf0, 0x30, 0, 0, 0, 0, 1])).unwrap();
    let once = blocks.block(&leaf([0xf0, 0xf0, 0x70, 0, 0, 0, 0, 1])).unwrap();
    let lit = Word::LIT;
    let root = blocks.block(&[often, lit, lit, once, lit, lit, lit, often]).unwrap();
    blocks.finish(root).number(3)
}

#[test]
fn lossy_worked_example() {
    let tree = nearly_equal();
    // Three occurrences of four leaves of eight each.
    assert_eq!(leaf_voxels(&tree), 3 * 4 * 8);
    let out = merge_similar(&tree, 0.011).unwrap();
    assert_eq!(out.change, LossyChange { max_share: 0.011, leaf_voxels: 96, changed_voxels: 1 });
    assert_eq!((out.merged_blocks, tree.bytes(), out.tree.bytes()), (1, 4 * 25, 4 * 17));
    // The block that occurs once was replaced.
    let voxel = morton::voxel(&[3, 2, 6]);
    assert!(tree.voxel(voxel) && !out.tree.voxel(voxel));
    // With this share the budget is less than one of the 96 voxels.
    assert_eq!(merge_similar(&tree, 0.010).unwrap().tree, tree);
}

#[test]
fn lossy_merges_similar_blocks_into_central_block() {
    // Five blocks that occur once each. Four differ from the third in one voxel, and from each other in two.
    let mut blocks = Interned::default();
    let [a, b, c, d, e] = [0x01, 0x05, 0x11, 0x21, 0x41]
        .map(|m: u8| blocks.block(&[0x0f, 0x33, m, 0, 0, 0, 0, 0].map(Word::leaf)).unwrap());
    let lit = Word::LIT;
    let root = blocks.block(&[b, c, a, d, e, lit, lit, lit]).unwrap();
    let tree = blocks.finish(root).number(3);
    let out = merge_similar(&tree, 0.05).unwrap();
    assert_eq!(leaf_voxels(&tree), 5 * 3 * 8);
    assert_eq!((out.merged_blocks, out.change.changed_voxels), (4, 4));
    assert_eq!(out.tree.words().len(), 17);
}

#[test]
fn lossy_replaces_whole_subtrees() {
    // Two blocks of blocks that share all but one child. Each occurs once together with that child, so
    // replacing one removes two blocks.
    let mut blocks = Interned::default();
    let low = |blocks: &mut Interned, m: u8| blocks.block(&[m, m, m, m, 0, 0, 0, 0].map(Word::leaf)).unwrap();
    let [shared, one, other] = [0x0f, 0x33, 0x37].map(|m| low(&mut blocks, m));
    let lit = Word::LIT;
    let mid =
        |blocks: &mut Interned, w: Word| blocks.block(&[shared, w, shared, lit, lit, lit, lit, lit]).unwrap();
    let [x, y] = [one, other].map(|w| mid(&mut blocks, w));
    let root = blocks.block(&[x, lit, lit, y, lit, lit, lit, lit]).unwrap();
    let tree = blocks.finish(root).number(4);
    let out = merge_similar(&tree, 4.0 / leaf_voxels(&tree) as f64).unwrap();
    assert_eq!(out.change.changed_voxels, 4);
    assert_eq!((tree.words().len(), out.tree.words().len()), (1 + 8 * 6, 1 + 8 * 4));
    assert_eq!(merge_similar(&tree, 3.0 / leaf_voxels(&tree) as f64).unwrap().tree, tree);
}

#[test]
fn lossy_does_not_depend_on_threads() {
    let tree = nearly_equal();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| merge_similar(&tree, 0.5).unwrap())
    };
    assert_eq!(on(1), on(5));
}

#[test]
fn lossy_accepts_trees_of_one_leaf() {
    for word in [Word::LIT, Word::SHADOWED, Word::leaf(7)] {
        let tree = VoxelTree::from_words(15, vec![word.0]).unwrap();
        assert_eq!(merge_similar(&tree, 1.0).unwrap().tree, tree);
    }
}

#[test]
fn lossy_refuses_a_share_out_of_range() {
    for share in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        let refused = merge_similar(&nearly_equal(), share);
        assert!(matches!(refused, Err(Error::Option(_))), "{share}");
    }
    assert!(merge_similar(&nearly_equal(), 1.0).is_ok());
}
