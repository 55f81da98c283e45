// Level of the block in which an unfiltered look-up ends. All columns of the block switch at one depth, and
// it spans 2^level columns a side. 0 is a single column. -1 means that the receiver is beside or in front of
// the grid. core/depths.wgsl must precede this file.

fn adumbra_voxel_end_level(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver) -> i32 {
    let asked = adumbra_voxel_of(v, r);
    if (asked.z < 0) {
        return -1;
    }
    let column = vec2u(asked.xy);
    let root = column >> vec2u(v.root_level);
    let entry = v.extra.x + 2u * (root.y * v.root_count.x + root.x);
    var node = AdumbraDepthsNode(adumbra_voxel_word(entry), adumbra_voxel_word(entry + 1u));
    var level = v.root_level;
    while (node.at < ADUMBRA_DEPTHS_ABSENT) {
        if (level == 3u) {
            return 0;
        }
        level -= 2u;
        let bits = (column >> vec2u(level)) & vec2u(3u);
        node = adumbra_depths_child(v, node, bits.y << 2u | bits.x);
    }
    return i32(level);
}
