//! Root cubes: the top grid of a graph.

/// Largest root level: a root cube spans 2^20 voxels along each side.
pub const MAX_ROOT_LEVEL: u32 = 20;
/// Level of the nodes whose children are leaf masks.
pub const LEAF_NODE_LEVEL: u32 = 3;

/// Returns the number of roots along x, y, z that cover `size` voxels: `ceil(size /
/// 2^root_level)`. `root_level` is at most 31.
pub fn top_dims(size: [u32; 3], root_level: u32) -> [u32; 3] {
    size.map(|n| n.div_ceil(1 << root_level.min(31)))
}
