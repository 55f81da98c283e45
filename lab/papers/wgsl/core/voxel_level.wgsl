// Level of the block in which an unfiltered look-up in a light-aligned graph ends. The whole block is lit or
// shadowed, and it spans 2^level voxels a side; at level 3 it may also be a leaf mask of 8 × 8 × 1. 0 is a
// single voxel. -1 means that the receiver is beside or in front of the grid. This is the counterpart of
// adumbra_papers::dag::DagQuery::end_level. core/voxel_graph.wgsl and a layout's file must precede this file.

fn adumbra_voxel_end_level(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver) -> i32 {
    let asked = adumbra_voxel_of(v, r);
    if (asked.z < 0) {
        return -1;
    }
    let voxel = vec3u(asked);
    var node = adumbra_voxel_root(v, voxel);
    while (node.state == ADUMBRA_VOXEL_MIXED && node.level > 3u) {
        node = adumbra_voxel_descend(v, node, voxel);
    }
    if (node.state != ADUMBRA_VOXEL_MIXED) {
        return i32(node.level);
    }
    let lit = adumbra_voxel_look_up(v, node, voxel.z & 7u, vec2u(0xffffffffu));
    return select(0, 3, all(lit == vec2u(0u)) || all(lit == vec2u(0xffffffffu)));
}
