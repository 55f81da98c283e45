//! Small random spaces for the tests of this folder.

use proptest::prelude::*;

use super::{Classify, State};

/// A space of 2^depth voxels a side, spelled out; cubes are decided by looking at every voxel.
#[derive(Debug)]
pub(super) struct Spelled {
    pub(super) depth: u32,
    pub(super) states: Vec<State>,
}

impl Spelled {
    /// The state of a voxel.
    pub(super) fn at(&self, xyz: [u32; 3]) -> State {
        let [x, y, z] = xyz.map(|c| c as usize);
        self.states[(x << self.depth | y) << self.depth | z]
    }
}

impl Classify for Spelled {
    fn cell(&self, xyz: [u32; 3], level: u32) -> State {
        assert_eq!(level, 0, "only voxels are cells");
        self.at(xyz)
    }

    fn cube(&self, xyz: [u32; 3], level: u32) -> Option<State> {
        let mut seen = State::Free;
        for i in 0..1 << (3 * level) {
            let offset = [i >> (2 * level), i >> level & ((1 << level) - 1), i & ((1 << level) - 1)];
            match self.at(std::array::from_fn(|a| xyz[a] + offset[a])) {
                State::Free => {}
                state if seen == State::Free || seen == state => seen = state,
                _ => return None,
            }
        }
        Some(seen)
    }
}

/// Few boxes over one state, some repeated along x.
pub(super) fn spaces() -> impl Strategy<Value = Spelled> {
    // Long runs, repeated parts, free insides.
    let boxes = proptest::collection::vec((any::<[u8; 6]>(), 0..3_u8), 0..8);
    (1..5_u32, boxes, 0..3_u8, any::<bool>()).prop_map(|(depth, boxes, fill, mirrored)| {
        let state = |s: u8| [State::Lit, State::Shadowed, State::Free][usize::from(s)];
        let side = 1_usize << depth;
        let mut states = vec![state(fill); side * side * side];
        for (corners, s) in boxes {
            let corners = corners.map(|c| usize::from(c) % side);
            let range = |a: usize| corners[a].min(corners[a + 3])..=corners[a].max(corners[a + 3]);
            for x in range(0) {
                for y in range(1) {
                    for z in range(2) {
                        let x = if mirrored { x % (side / 2).max(1) } else { x };
                        states[(x * side + y) * side + z] = state(s);
                    }
                }
            }
        }
        Spelled { depth, states }
    })
}
