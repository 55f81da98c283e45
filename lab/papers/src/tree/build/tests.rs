//! Compares the builders and reductions with each other and with the voxels themselves.

use crate::tree::build::*;
use crate::tree::graph::VoxelTree;
use crate::tree::kit::{Spelled, all_voxels, spaces};
use crate::tree::reduce::tree_hash::TreeHashed;
use crate::tree::reduce::{Interned, sort};
use proptest::prelude::*;

proptest! {
    #[test]
    fn tree_builders_agree_and_match_every_defined_voxel(space in spaces()) {
        let depth = space.depth;
        let tree = TreeBuilder::Recursive.tree(&space, depth, false).unwrap();
        for builder in TreeBuilder::ALL {
            for prune in [false, true] {
                prop_assert_eq!(&builder.tree(&space, depth, prune).unwrap(), &tree);
            }
        }
        let numbered = tree.number(depth);
        prop_assert_eq!(VoxelTree::from_words(depth, numbered.words().to_vec()), Ok(numbered.clone()));
        for xyz in all_voxels(depth) {
            match space.at(xyz) {
                State::Lit => prop_assert!(numbered.voxel(xyz)),
                State::Shadowed => prop_assert!(!numbered.voxel(xyz)),
                State::Free => {}
            }
        }
    }

    #[test]
    fn tree_reductions_agree_and_keep_every_voxel(space in spaces()) {
        let depth = space.depth;
        let tree = TreeBuilder::Recursive.tree(&space, depth, false).unwrap();
        let (sorted, _) = sort(tree.clone());
        let numbered = sorted.number(depth);
        prop_assert_eq!(VoxelTree::from_words(depth, numbered.words().to_vec()), Ok(numbered.clone()));
        let mut distinct = sorted.blocks.clone();
        distinct.sort();
        distinct.dedup();
        prop_assert_eq!(distinct.len(), sorted.blocks.len());
        let mut interned = Interned::default();
        let root = TreeBuilder::Pooled.build(&space, depth, true, &mut interned, &|_, _| Ok(())).unwrap();
        prop_assert_eq!(&interned.finish(root).number(depth), &numbered);
        for modulus in [2, 251, crate::tree::reduce::tree_hash::MODULUS] {
            let mut hashed = TreeHashed::with_modulus(modulus);
            let root = TreeBuilder::Iterative.build(&space, depth, false, &mut hashed, &|_, _| Ok(())).unwrap();
            prop_assert_eq!(&hashed.finish(root).number(depth), &numbered);
        }
        prop_assert_eq!(&Blocks::of(&numbered).number(depth), &numbered);
        let whole = tree.number(depth);
        for xyz in all_voxels(depth) {
            prop_assert_eq!(numbered.voxel(xyz), whole.voxel(xyz));
        }
    }
}

#[test]
fn tree_hash_collisions_are_counted_and_change_nothing() {
    let space = Spelled {
        depth: 4,
        coarse: false,
        states: (0..4096_u32).map(|i| if i % 7 * i % 5 < 3 { State::Lit } else { State::Shadowed }).collect(),
    };
    let reduce = |modulus| {
        let mut hashed = TreeHashed::with_modulus(modulus);
        let root = TreeBuilder::Recursive.build(&space, 4, false, &mut hashed, &|_, _| Ok(())).unwrap();
        let collisions = hashed.collisions();
        (hashed.finish(root).number(4), collisions)
    };
    let (exact, none) = reduce(crate::tree::reduce::tree_hash::MODULUS);
    let (crowded, many) = reduce(3);
    assert_eq!(exact, crowded);
    assert_eq!(none, 0);
    assert!(many > 0);
}

#[test]
fn tree_rejects_invalid_words() {
    use crate::tree::TreeError as E;
    let lit = Word::LIT.0;
    let mask = Word::leaf(3).0;
    let block = |first: u32| [first, lit, lit, lit, lit, lit, lit, lit];
    let tree =
        |root: &[u32], blocks: &[[u32; 8]]| VoxelTree::from_words(3, [root, blocks.as_flattened()].concat());
    assert!(tree(&[1], &[block(mask)]).is_ok());
    assert_eq!(VoxelTree::from_words(0, vec![lit]), Err(E::Depth { depth: 0 }));
    assert_eq!(VoxelTree::from_words(16, vec![lit]), Err(E::Depth { depth: 16 }));
    assert_eq!(tree(&[], &[]), Err(E::Length { words: 0 }));
    assert_eq!(tree(&[1, lit], &[]), Err(E::Length { words: 2 }));
    assert_eq!(tree(&[0x8000_0004], &[]), Err(E::Word { index: 0, word: 0x8000_0004 }));
    assert_eq!(tree(&[9], &[block(mask)]), Err(E::Index { index: 0, target: 9 }));
    assert_eq!(tree(&[2], &[block(mask)]), Err(E::Index { index: 0, target: 2 }));
    assert_eq!(tree(&[9], &[block(mask), block(1)]), Err(E::Order { block: 9 }));
    assert_eq!(tree(&[1], &[block(mask), block(mask)]), Err(E::Order { block: 9 }));
    assert_eq!(tree(&[1], &[block(1)]), Err(E::TooDeep { block: 1, depth: 3 }));
    assert_eq!(tree(&[1], &[block(9), block(17), block(mask)]), Err(E::TooDeep { block: 17, depth: 3 }));
    assert_eq!(tree(&[1], &[block(lit)]), Err(E::NotMerged { block: 1 }));
    // A shared block is as deep as its lowest occurrence.
    let shared = [9, 17, lit, lit, lit, lit, lit, lit];
    let deep = |depth| VoxelTree::from_words(depth, [&[1][..], &shared, &block(mask), &block(9)].concat());
    assert_eq!(deep(4).map(|t| t.depth()), Ok(4));
    assert_eq!(deep(3), Err(E::TooDeep { block: 9, depth: 3 }));
}
