// Nodes of a light-aligned graph in the plain layout; the counterpart of adumbra_papers::dag::plain::Dag,
// which documents the words. Words: top, nodes and leaf masks are concatenated, the latter two from
// `extra.x` and `code_offset` on. A node's position is that of its header. Source: see core/voxel.wgsl.

// Returns the root that contains a voxel.
fn adumbra_voxel_root(v: AdumbraVoxelParams, voxel: vec3u) -> AdumbraVoxelNode {
    let root = voxel >> vec3u(v.root_level);
    let word = adumbra_voxel_word((root.z * v.root_count.y + root.y) * v.root_count.x + root.x);
    if (word >= ADUMBRA_TOP_SHADOWED) {
        return AdumbraVoxelNode(select(0u, 1u, word == ADUMBRA_TOP_LIT), v.root_level, 0u);
    }
    return AdumbraVoxelNode(ADUMBRA_VOXEL_MIXED, v.root_level, v.extra.x + word);
}

// Returns the state of a child, two bits of a mixed node's header.
fn adumbra_voxel_child(header: u32, child: u32) -> u32 {
    return (header >> (2u * child)) & 3u;
}

// Returns the pointer of a mixed child. The pointers of all mixed children follow the header in child order.
fn adumbra_voxel_pointer(node: AdumbraVoxelNode, header: u32, child: u32) -> u32 {
    return adumbra_voxel_word(node.at + 1u + countOneBits(header & 0xaaaau & ((1u << (2u * child)) - 1u)));
}

// Descends from a mixed node above level 3 to the child that contains a voxel.
fn adumbra_voxel_descend(v: AdumbraVoxelParams, node: AdumbraVoxelNode, voxel: vec3u) -> AdumbraVoxelNode {
    let level = node.level - 1u;
    let bits = (voxel >> vec3u(level)) & vec3u(1u);
    let child = bits.x << 2u | bits.y << 1u | bits.z;
    let header = adumbra_voxel_word(node.at);
    let state = adumbra_voxel_child(header, child);
    if (state < ADUMBRA_VOXEL_MIXED) {
        return AdumbraVoxelNode(state, level, 0u);
    }
    return AdumbraVoxelNode(ADUMBRA_VOXEL_MIXED, level, v.extra.x + adumbra_voxel_pointer(node, header, child));
}

// Returns the lit bits of `mask` in leaf mask z of a mixed node of level 3.
fn adumbra_voxel_look_up(v: AdumbraVoxelParams, node: AdumbraVoxelNode, z: u32, mask: vec2u) -> vec2u {
    let header = adumbra_voxel_word(node.at);
    let state = adumbra_voxel_child(header, z);
    if (state < ADUMBRA_VOXEL_MIXED) {
        return state * mask;
    }
    return adumbra_leaf_mask_look_up(v, adumbra_voxel_pointer(node, header, z), mask);
}
