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
    /// Number of leaves with a gradient.
    pub slanted_leaves: u64,
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
        let mut census = Census::default();
        let code = self.shapes();
        self.for_each_shape(|ShapePlace { at, level }| {
            if level == LEAF_LEVEL {
                let head = LeafHead::new(code.half(at));
                census.leaves += 1;
                census.slanted_leaves += u64::from(head.slanted);
                census.depth_bytes += 2 * u64::from(head.planes_at());
                census.plane_bytes += 8 * u64::from(head.planes());
                return;
            }
            census.nodes += 1;
            census.head_bytes += 6;
            let [low, high, kind] = [0, 1, 2].map(|h| code.half(at + h));
            census.field_bytes += 2 * u64::from(fields_length(low, high, kind, 0xffff));
        });
        census
    }
}
