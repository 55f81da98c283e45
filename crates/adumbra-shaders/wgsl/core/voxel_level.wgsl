// Level of the block in which an unfiltered look-up in a light-aligned graph ends: all of it is lit or shadowed, and it spans 2^level
// voxels a side, at level 3 also a slab of 8 × 8 × 1; 0 = a single voxel, -1 beside the grid and before it. The twin of
// adumbra::query::Query::end_level. core/voxel_graph.wgsl and a layout's file go before it.

fn voxel_end_level(v: VoxelParams, r: VoxelReceiver) -> i32 {
    let asked = voxel_of(v, r);
    if (asked.z < 0) {
        return -1;
    }
    let voxel = vec3u(asked);
    var node = voxel_root(v, voxel);
    while (node.state == VOXEL_MIXED && node.level > 3u) {
        node = voxel_descend(v, node, voxel);
    }
    if (node.state != VOXEL_MIXED) {
        return i32(node.level);
    }
    let lit = voxel_slab_bits(v, node, voxel.z & 7u, vec2u(0xffffffffu));
    return select(0, 3, all(lit == vec2u(0u)) || all(lit == vec2u(0xffffffffu)));
}
