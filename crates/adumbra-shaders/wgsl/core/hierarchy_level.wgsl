// Level of the block in which an unfiltered look-up in a hierarchy ends: all its columns switch at one depth, and it spans 2^level
// columns a side; 0 = a single column, -1 beside the grid and before it. The twin of adumbra::query::Query::end_level.
// core/hierarchy.wgsl goes before it.

fn hierarchy_end_level(v: VoxelParams, r: VoxelReceiver) -> i32 {
    let asked = voxel_of(v, r);
    if (asked.z < 0) {
        return -1;
    }
    let column = vec2u(asked.xy);
    let root = column >> vec2u(v.top_dims.w);
    let entry = 2u * (root.y * v.top_dims.x + root.x);
    var p = HierarchyPlace(voxel_word(entry), voxel_word(entry + 1u));
    var level = v.top_dims.w;
    while (p.at != HIERARCHY_UNIFORM) {
        if (level == 3u) {
            return 0;
        }
        level -= 2u;
        let bits = (column >> vec2u(level)) & vec2u(3u);
        p = hierarchy_child(v, p, bits.y << 2u | bits.x);
    }
    return i32(level);
}
