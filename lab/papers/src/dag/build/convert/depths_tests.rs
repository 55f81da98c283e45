//! Conversions from quadtrees to graphs and back keep every voxel.

use adumbra::layout::depths::{DepthTree, NEVER};
use adumbra_testing::{Leaf, from_leaves};
use proptest::prelude::*;

use crate::dag::LeafMasks;
use crate::dag::build::convert::{depths_of, graph_of_depths};

const DEPTH: u32 = 3_000;

/// Returns leaves of up to three depths, some of which are beyond the grid's end.
fn any_leaves() -> impl Strategy<Value = Vec<Leaf>> {
    let leaf = (prop::collection::vec(0_u32..2_000, 1..3), any::<bool>(), any::<u64>()).prop_map(
        |(differences, never, seed)| {
            let ranks = differences.len() as u64 + 1 + u64::from(never);
            let rank = |column: u64| ((seed >> (column / 8 + column % 8)) % ranks) as u32;
            Leaf { width: 2, ranks: (0..64).map(rank).collect(), differences, never, ..Leaf::default() }
        },
    );
    prop::collection::vec(leaf, 16)
}

/// Returns the layer before which a column is lit.
fn switch(depths: &DepthTree, i: u32, j: u32) -> u32 {
    match depths.value(i, j) {
        NEVER => DEPTH,
        depth => depth.min(DEPTH),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn depths_round_trip_through_graph(leaves in any_leaves(), base in 0_u32..3_500) {
        let found = from_leaves(&leaves, 4, base, DEPTH).unwrap();
        let dag = graph_of_depths(&found).unwrap();
        prop_assert_eq!(dag.validate(), Ok(()));
        let again = depths_of(&dag, 5).unwrap();
        for (i, j) in (0..found.size()[1]).flat_map(|j| (0..found.size()[0]).map(move |i| (i, j))) {
            let value = switch(&found, i, j);
            prop_assert_eq!(switch(&again, i, j), value);
            prop_assert!(value == 0 || dag.voxel(i, j, value - 1));
            prop_assert!(value == DEPTH || !dag.voxel(i, j, value));
        }
    }
}
