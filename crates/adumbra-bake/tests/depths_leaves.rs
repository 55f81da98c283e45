//! Leaves of the quadtree: columns' depths follow the specification, one at a time and all at once.

use adumbra::layout::depths::code::ColumnNode;
use adumbra::layout::depths::{DepthTree, DepthsError, Part};
use adumbra_scene::random::Random;
use adumbra_testing::{BASES, Leaf, TreeParts, every_gradient, from_leaves, random_leaves};

/// The page of a small tree.
const PAGE: Part = Part::Page([0, 0]);

/// Checks every column of a leaf, one at a time and all at once, and the bounds of all.
fn check_leaf(found: &DepthTree, leaf: &Leaf, base: u32, [i, j]: [u32; 2]) {
    let depths: [u32; 64] = std::array::from_fn(|column| leaf.depth(base, column).unwrap_or(u32::MAX));
    for (column, &depth) in depths.iter().enumerate() {
        let column = column as u32;
        assert_eq!(found.value(i + column % 8, j + column / 8), depth, "{leaf:?} of {base}: {column}");
    }
    let ColumnNode::Leaf { at, base } = found.place(i, j).0 else { panic!("{leaf:?} is not stored") };
    let of_leaf = found.shapes().leaf(at, base);
    assert_eq!(of_leaf.values(), depths, "{leaf:?} of {base}");
    let [nearest, farthest] = of_leaf.bounds();
    assert!(depths.iter().all(|depth| (nearest..=farthest).contains(depth)), "{leaf:?} of {base}");
}

#[test]
fn depths_follow_the_specification_for_every_gradient() {
    let base = 452;
    let leaves = every_gradient();
    let found = from_leaves(&leaves, 256, base, 1024).expect("valid leaves");
    for (at, leaf) in leaves.iter().enumerate() {
        let corner = [at % 256, at / 256].map(|c| 8 * c as u32);
        check_leaf(&found, leaf, base, corner);
    }
}

#[test]
fn depths_follow_the_specification_for_any_ranks_and_bases() {
    let mut random = Random::for_batch(7, 0);
    for case in 0..400 {
        let leaves = random_leaves(&mut random, case);
        let base = BASES[case % BASES.len()];
        let found = from_leaves(&leaves, 4, base, u32::MAX).expect("valid leaves");
        for (at, leaf) in leaves.iter().enumerate() {
            let corner = [at % 4, at / 4].map(|c| 8 * c as u32);
            check_leaf(&found, leaf, base, corner);
        }
    }
}

/// Returns the error for which depths of sixteen equal leaves are refused.
fn fault(leaf: &Leaf) -> Option<DepthsError> {
    from_leaves(&vec![leaf.clone(); 16], 4, 10, 64).err()
}

#[test]
fn rank_above_the_last_depth_is_refused() {
    let mut leaf = Leaf { width: 1, differences: vec![5, 5], ranks: vec![0; 64], ..Leaf::default() };
    assert_eq!(fault(&leaf), None);
    leaf.ranks[9] = 3;
    assert_eq!(fault(&leaf), Some(DepthsError::Ranks { part: PAGE, at: 0, column: 9, last: 2 }));
    // The last depth, which never switches, is a valid rank; the next number is not.
    leaf.never = true;
    assert_eq!(fault(&leaf), None);
    leaf.differences.push(1);
    leaf.ranks[9] = 5;
    assert_eq!(fault(&leaf), Some(DepthsError::Ranks { part: PAGE, at: 0, column: 9, last: 4 }));
}

#[test]
fn byte_behind_an_odd_number_of_differences_must_be_zero() {
    let leaf = Leaf { width: 1, differences: vec![5; 3], ranks: vec![3; 64], ..Leaf::default() };
    let mut found = TreeParts::of(&from_leaves(&vec![leaf; 16], 4, 10, 64).expect("valid leaves"));
    // Half-words 1 and 2 are the differences.
    let words = &mut found.pages[0].words;
    assert_eq!((words[0] >> 16, words[1] & 0xffff), (0x0505, 0x0005));
    words[1] |= 0x0100;
    assert_eq!(found.tree(), Err(DepthsError::Bits { part: PAGE, at: 0, level: 3, half: 0x0105 }));
}
