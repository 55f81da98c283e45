//! Breakdown of the bytes of a quadtree of depths.

use crate::layout::depths::child::ShapePlace;
use crate::layout::depths::code::fields_length;
use crate::layout::depths::leaf::LeafHead;
use crate::layout::depths::{DepthTree, LEAF_LEVEL};

/// Bytes of a quadtree of depths by kind, and the number of its shapes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// Number of nodes above the leaves.
    pub nodes: u64,
    /// Number of leaves.
    pub leaves: u64,
    /// Number of children of nodes by encoding, 4·high + 2·low + kind of the table in
    /// [`crate::layout::depths`].
    pub children: [u64; 8],
    /// Number of leaves by their number of planes, from 0 on.
    pub leaves_by_planes: [u64; 7],
    /// Number of leaves with a gradient.
    pub slanted_leaves: u64,
    /// Bytes of the addresses and bases of the blocks at which look-ups begin.
    pub top_bytes: u64,
    /// Bytes of the common section.
    pub common_bytes: u64,
    /// Bytes of the heads of nodes.
    pub head_bytes: u64,
    /// Bytes of the pointers and differences of nodes.
    pub field_bytes: u64,
    /// Bytes of the heads and differences of leaves.
    pub depth_bytes: u64,
    /// Bytes of the planes of leaves.
    pub plane_bytes: u64,
}

impl DepthTree {
    /// Counts the shapes and their bytes. Cost: one visit per shape, and a byte of memory per half-word.
    pub fn census(&self) -> Census {
        let mut census = Census {
            top_bytes: 8 * self.top().len() as u64,
            common_bytes: 4 * self.common_words as u64,
            ..Census::default()
        };
        let code = self.shapes();
        self.for_each_shape(|ShapePlace { at, level }| {
            if level == LEAF_LEVEL {
                let head = LeafHead::new(code.half(at));
                census.leaves += 1;
                census.leaves_by_planes[head.planes() as usize] += 1;
                census.slanted_leaves += u64::from(head.slanted);
                census.depth_bytes += 2 * u64::from(head.planes_at());
                census.plane_bytes += 8 * u64::from(head.planes());
                return;
            }
            census.nodes += 1;
            census.head_bytes += 6;
            let [low, high, kind] = [0, 1, 2].map(|h| code.half(at + h));
            census.field_bytes += 2 * u64::from(fields_length(low, high, kind, 0xffff));
            for c in 0..16 {
                let [low, high, kind] = [low, high, kind].map(|half| half >> c & 1);
                census.children[(4 * high + 2 * low + kind) as usize] += 1;
            }
        });
        census
    }
}
