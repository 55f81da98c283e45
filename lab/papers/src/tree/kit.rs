//! Small random spaces for the tests of this crate.

use proptest::prelude::*;

use crate::tree::build::{Classify, State};

/// A space with sides of 2^depth voxels, given voxel by voxel. Cubes are decided by examining every cell.
#[derive(Debug)]
pub(crate) struct Spelled {
    pub(crate) depth: u32,
    /// If true, the cells in the upper half along x are cubes of two voxels a side, as in a region of lower
    /// depth, and the lowest voxel of each cell determines its state. Needs at least two levels.
    pub(crate) coarse: bool,
    pub(crate) states: Vec<State>,
}

impl Spelled {
    /// Returns the state of a voxel, which is that of its cell.
    pub(crate) fn at(&self, xyz: [u32; 3]) -> State {
        let level = self.cell_level(xyz);
        let [x, y, z] = xyz.map(|c| (c >> level << level) as usize);
        self.states[(x << self.depth | y) << self.depth | z]
    }

    fn cell_level(&self, xyz: [u32; 3]) -> u32 {
        u32::from(self.coarse && xyz[0] >= 1 << (self.depth - 1))
    }
}

impl Classify for Spelled {
    fn is_cell(&self, xyz: [u32; 3], level: u32) -> bool {
        level <= self.cell_level(xyz)
    }

    fn cell(&self, xyz: [u32; 3], level: u32) -> State {
        assert!(self.is_cell(xyz, level), "only cells are tested");
        self.at(xyz)
    }

    fn cube(&self, xyz: [u32; 3], level: u32) -> Option<State> {
        let mut seen = State::Free;
        for offset in all_voxels(level) {
            match self.at(std::array::from_fn(|a| xyz[a] + offset[a])) {
                State::Free => {}
                state if seen == State::Free || seen == state => seen = state,
                _ => return None,
            }
        }
        Some(seen)
    }
}

/// Returns every voxel of a cube of this level.
pub(crate) fn all_voxels(level: u32) -> impl Iterator<Item = [u32; 3]> {
    let last = (1 << level) - 1;
    (0..1_u32 << (3 * level)).map(move |i| [i >> (2 * level), i >> level & last, i & last])
}

/// Calls `put` for every voxel of the box between two corners, which are taken modulo `side`.
fn for_each_in_box(corners: [u8; 6], side: usize, mut put: impl FnMut([usize; 3])) {
    let corners = corners.map(|c| usize::from(c) % side);
    let range = |a: usize| corners[a].min(corners[a + 3])..=corners[a].max(corners[a + 3]);
    for x in range(0) {
        for y in range(1) {
            for z in range(2) {
                put([x, y, z]);
            }
        }
    }
}

/// A few boxes over a uniform background, some repeated along x.
pub(crate) fn spaces() -> impl Strategy<Value = Spelled> {
    // Produces long runs, repeated parts and free interiors.
    let boxes = proptest::collection::vec((any::<[u8; 6]>(), 0..3_u8), 0..8);
    (1..5_u32, boxes, 0..3_u8, any::<bool>()).prop_map(|(depth, boxes, fill, mirrored)| {
        let state = |s: u8| [State::Lit, State::Shadowed, State::Free][usize::from(s)];
        let side = 1_usize << depth;
        let mut states = vec![state(fill); side * side * side];
        for (corners, s) in boxes {
            for_each_in_box(corners, side, |[x, y, z]| {
                let x = if mirrored { x % (side / 2).max(1) } else { x };
                states[(x * side + y) * side + z] = state(s);
            });
        }
        Spelled { depth, coarse: false, states }
    })
}

/// Boxes, plus flipped single voxels: repeated parts that differ slightly. Some spaces are coarse.
pub(crate) fn noisy_spaces() -> impl Strategy<Value = Spelled> {
    let boxes = proptest::collection::vec((any::<[u8; 6]>(), any::<bool>()), 0..8);
    let flips = proptest::collection::vec(any::<[u8; 3]>(), 0..24);
    (2..6_u32, boxes, flips, 0..3_u32, any::<bool>()).prop_map(|(depth, boxes, flips, period, coarse)| {
        let side = 1_usize << depth;
        // The pattern repeats every side / 2^period voxels, at least 2.
        let tile = (side >> period).max(2);
        let at = |x: usize, y: usize, z: usize| (x * side + y) * side + z;
        let mut pattern = vec![false; side * side * side];
        for (corners, lit) in boxes {
            for_each_in_box(corners, tile, |[x, y, z]| pattern[at(x, y, z)] = lit);
        }
        let repeated = (0..pattern.len()).map(|i| {
            let [x, y, z] = [i / side / side, i / side % side, i % side].map(|c| c % tile);
            pattern[at(x, y, z)]
        });
        let mut lit: Vec<bool> = repeated.collect();
        for [x, y, z] in flips {
            let [x, y, z] = [x, y, z].map(|c| usize::from(c) % side);
            lit[at(x, y, z)] ^= true;
        }
        let states = lit.into_iter().map(|lit| if lit { State::Lit } else { State::Shadowed }).collect();
        Spelled { depth, coarse, states }
    })
}
