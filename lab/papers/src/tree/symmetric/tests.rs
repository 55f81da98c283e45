//! Compares the bytes with the words that they represent, and tests damaged bytes.

use proptest::prelude::*;

use crate::tree::blocks::Blocks;
use crate::tree::build::{State, TreeBuilder};
use crate::tree::graph::VoxelTree;
use crate::tree::kit::{Spelled, all_voxels, spaces};
use crate::tree::reduce::Interned;
use crate::tree::symmetric::mirror::{Image, mirror};
use crate::tree::symmetric::{SymmetricError as E, SymmetricTree};
use crate::tree::word::{Node, Word};

fn reduced(space: &Spelled) -> VoxelTree {
    let mut blocks = Interned::default();
    let root = TreeBuilder::Pooled.build(space, space.depth, true, &mut blocks, &|_, _| Ok(())).unwrap();
    blocks.finish(root).number(space.depth)
}

/// Returns the space with its two halves along each axis of `both` made mirror images of each other.
fn with_images(mut space: Spelled, both: u8) -> Spelled {
    let side = 1_u32 << space.depth;
    let states = all_voxels(space.depth).map(|xyz| {
        let folded = |a: usize| both >> (2 - a) & 1 == 1 && xyz[a] >= side / 2;
        space.at(std::array::from_fn(|a| if folded(a) { side - 1 - xyz[a] } else { xyz[a] }))
    });
    space.states = states.collect();
    space
}

/// Builds a tree of `depth` levels from its root and blocks, children first.
fn tree(depth: u32, root: Word, blocks: &[[Word; 8]]) -> VoxelTree {
    let numbered = Blocks { root, blocks: blocks.to_vec() }.number(depth);
    VoxelTree::from_words(depth, numbered.words().to_vec()).unwrap()
}

fn inner(block: u32) -> Word {
    Word::new(Node::Inner(block))
}

const S: Word = Word::SHADOWED;
const L: Word = Word::LIT;

proptest! {
    #[test]
    fn symmetric_matches_words_and_decodes_to_them(space in spaces(), both in 0..8_u8) {
        let words = reduced(&with_images(space, both));
        let depth = words.depth();
        let [plain, mirrored] = [false, true].map(|mirrors| SymmetricTree::of(&words, mirrors).unwrap());
        prop_assert!(mirrored.node_count() <= plain.node_count());
        prop_assert_eq!(plain.node_count() as usize, words.words().len() / 8);
        for (made, mirrors) in [(plain, false), (mirrored, true)] {
            prop_assert_eq!(made.mirrors(), mirrors);
            for xyz in all_voxels(depth) {
                prop_assert_eq!(made.find(xyz), words.find(xyz));
            }
            let unpacked = made.to_tree().unwrap();
            prop_assert_eq!(&unpacked, &words);
            let read = SymmetricTree::from_bytes(depth, made.bytes().to_vec());
            prop_assert_eq!(read.as_ref(), Ok(&made));
            prop_assert_eq!(&SymmetricTree::of(&unpacked, mirrors).unwrap(), &made);
        }
    }

    #[test]
    fn symmetric_mirrored_halves_are_stored_once(space in spaces(), axis in 0..3_u32) {
        let axis = 1 << axis;
        let words = reduced(&with_images(space, axis));
        let graph = mirror(&Blocks::of(&words), true);
        if let Node::Inner(root) = graph.root.node() {
            let block = graph.nodes[Image::of(root).node as usize];
            for i in 0..8 {
                if let [Node::Inner(a), Node::Inner(b)] = [i, i ^ usize::from(axis)].map(|i| block[i].node()) {
                    prop_assert_eq!(Image::of(a).node, Image::of(b).node);
                }
            }
        }
    }
}

#[test]
fn symmetric_worked_example() {
    // The example of the specification: child 0 of the root and child 4 are mirror images of each other along
    // x.
    let low = [Word::leaf(0x01), L, S, S, S, S, S, S];
    let high = [S, S, S, S, Word::leaf(0x10), L, S, S];
    let words = tree(3, inner(2), &[low, high, [inner(0), S, S, S, inner(1), S, S, L]]);
    let mirrored = SymmetricTree::of(&words, true).unwrap();
    assert_eq!(mirrored.node_count(), 2);
    assert_eq!(SymmetricTree::of(&words, false).unwrap().node_count(), 3);
    let expected: [&[u8]; 4] = [
        // Flags, and a root at 12.
        &[1, 0, 0, 0, 12, 0, 0, 0],
        // At 8: child 4 is a mask, child 5 is lit.
        &[0x00, 0xb0, 0x00, 0x10],
        // At 12: child 0 of kind 6, child 4 of kind 5, child 7 lit. 0x44: address 8, mirrored along x.
        &[0x06, 0x50, 0x20, 0x44, 0x00, 0x00, 0x08, 0x00],
        &[0, 0, 0, 0],
    ];
    assert_eq!(mirrored.bytes(), expected.concat());
    for xyz in all_voxels(3) {
        assert_eq!(mirrored.find(xyz), words.find(xyz));
    }
}

#[test]
fn symmetric_uses_smallest_mirror_of_self_symmetric_subtree() {
    // The node is its own mirror image along y, so its mirrors x and xy mean the same.
    let own = [Word::leaf(0x05), S, Word::leaf(0x05), S, L, S, L, S];
    let x = [L, S, L, S, Word::leaf(0x50), S, Word::leaf(0x50), S];
    let blocks = Blocks {
        root: inner(4),
        blocks: vec![
            own,
            x,
            // These two are mirror images of each other along y and have the same two images below, so they
            // are one node, which is its own mirror image again.
            [inner(0), inner(1), S, S, S, S, S, S],
            [S, S, inner(0), inner(1), S, S, S, S],
            [inner(2), S, S, inner(3), L, S, S, S],
        ],
    };
    let graph = mirror(&blocks, true);
    assert_eq!(graph.nodes.len(), 3);
    assert_eq!(mirror(&blocks, false).nodes.len(), 5);
    for word in graph.nodes.iter().flatten() {
        if let Node::Inner(index) = word.node()
            && Image::of(index).node == 0
        {
            assert_eq!(Image::of(index).mirror & 2, 0);
        }
    }
}

#[test]
fn symmetric_round_trips_trees_of_one_leaf() {
    for root in [S, L, Word::leaf(0x35)] {
        for mirrors in [false, true] {
            let words = tree(2, root, &[]);
            let made = SymmetricTree::of(&words, mirrors).unwrap();
            assert_eq!(made.bytes().len(), 12);
            assert_eq!(made.node_count(), 0);
            assert_eq!(SymmetricTree::from_bytes(2, made.bytes().to_vec()).as_ref(), Ok(&made));
            assert_eq!(made.to_tree().unwrap(), words);
            for xyz in all_voxels(2) {
                assert_eq!(made.find(xyz), words.find(xyz));
            }
        }
    }
}

#[test]
fn symmetric_rejects_invalid_bodies() {
    let body = |root: u32, nodes: &[u8]| {
        let mut bytes = [1, 0, 0, 0].to_vec();
        bytes.extend(root.to_le_bytes());
        bytes.extend(nodes);
        bytes.resize((bytes.len() + 4).next_multiple_of(4), 0);
        SymmetricTree::from_bytes(3, bytes).map(|t| t.node_count())
    };
    // Child 0 is a mask, or a node by pointers of kinds 2, 4 and 5.
    let mask = [3, 0, 0, 0x0f];
    assert_eq!(body(8, &mask), Ok(1));
    assert_eq!(body(8, &[&[2, 0, 0][..], &mask].concat()), Ok(2));
    assert_eq!(body(8, &[&[4, 0, 0, 0][..], &mask].concat()), Ok(2));
    assert_eq!(body(8, &[&[5, 0, 0, 13, 0][..], &mask].concat()), Ok(2));
    assert_eq!(SymmetricTree::from_bytes(0, vec![0; 12]), Err(E::Depth { depth: 0 }));
    assert_eq!(SymmetricTree::from_bytes(3, vec![0; 8]), Err(E::Length { bytes: 8 }));
    assert_eq!(SymmetricTree::from_bytes(3, vec![0; 13]), Err(E::Length { bytes: 13 }));
    assert_eq!(SymmetricTree::from_bytes(3, vec![2; 12]), Err(E::Flags { flags: 0x0202_0202 }));
    assert_eq!(body(0x8000_0002, &[]), Err(E::Root { root: 0x8000_0002 }));
    assert_eq!(body(8, &[]), Err(E::Pointer { at: 0, target: 8 }));
    assert_eq!(body(9, &mask), Err(E::Pointer { at: 0, target: 9 }));
    assert_eq!(body(0x8000_0000, &mask), Err(E::Unreached { nodes: 1 }));
    assert_eq!(body(8, &[3, 0, 0, 0xff]), Err(E::Mask { at: 8, mask: 0xff }));
    assert_eq!(body(8, &[0x09, 0, 0]), Err(E::NotMerged { at: 8 }));
    assert_eq!(body(8, &[5, 0, 0, 12, 0, 3, 0, 0, 0x0f]), Err(E::Pointer { at: 8, target: 12 }));
    // A node that is its own descendant, and one deeper than three levels.
    assert_eq!(body(8, &[5, 0, 0, 8, 0]), Err(E::TooDeep { at: 8, depth: 3 }));
    assert_eq!(body(8, &[&[2, 0, 0, 2, 0, 0][..], &mask].concat()), Err(E::TooDeep { at: 14, depth: 3 }));
    // Eight pointers of four bytes, cut off.
    assert_eq!(body(8, &[0xff; 8]), Err(E::Cut { at: 8 }));
}

/// A tree with children of all kinds and a few mirrors.
fn busy() -> VoxelTree {
    let state = |i: u32| {
        let [x, y, z] = [i >> 10, i >> 5 & 31, i & 31];
        let x = if y % 8 < 4 { x } else { 31 - x };
        if (x * x + 3 * y + z * z / 5) % 37 < 20 { State::Lit } else { State::Shadowed }
    };
    reduced(&Spelled { depth: 5, coarse: false, states: (0..1 << 15).map(state).collect() })
}

#[test]
fn symmetric_refuses_every_truncation() {
    for mirrors in [false, true] {
        let made = SymmetricTree::of(&busy(), mirrors).unwrap();
        for length in 0..made.bytes().len() {
            assert!(SymmetricTree::from_bytes(5, made.bytes()[..length].to_vec()).is_err(), "{length}");
        }
    }
}

#[test]
fn symmetric_survives_random_damage() {
    let made = [false, true].map(|mirrors| SymmetricTree::of(&busy(), mirrors).unwrap());
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut taken = 0;
    for round in 0..50_000 {
        let mut bytes = made[round % 2].bytes().to_vec();
        for _ in 0..1 + random(2) {
            let at = random(bytes.len());
            bytes[at] = random(256) as u8;
        }
        let Ok(read) = SymmetricTree::from_bytes(5, bytes) else { continue };
        taken += 1;
        for _ in 0..16 {
            let xyz = [random(32) as u32, random(32) as u32, random(32) as u32];
            let (_, level) = read.find(xyz);
            assert!(level <= 5);
        }
        if taken % 64 == 0 {
            let words = read.to_tree().unwrap();
            assert_eq!(VoxelTree::from_words(5, words.words().to_vec()).as_ref(), Ok(&words));
            assert!(all_voxels(5).step_by(7).all(|xyz| words.voxel(xyz) == read.voxel(xyz)));
        }
    }
    assert!(taken > 1000, "{taken}");
}
