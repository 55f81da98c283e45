// Nodes of a light-aligned graph in the plain layout; the twin of adumbra::dag::Dag, whose text has the words. Words: top, nodes and slabs
// one behind the other, the latter two from `places.x` and `places.y` on. A node is where its header is. Source: as core/voxel.wgsl.

// The root over a voxel.
fn voxel_root(v: VoxelParams, voxel: vec3u) -> VoxelNode {
    let root = voxel >> vec3u(v.top_dims.w);
    let word = voxel_word((root.z * v.top_dims.y + root.y) * v.top_dims.x + root.x);
    if (word >= TOP_SHADOWED) {
        return VoxelNode(select(0u, 1u, word == TOP_LIT), v.top_dims.w, 0u);
    }
    return VoxelNode(VOXEL_MIXED, v.top_dims.w, v.places.x + word);
}

// Two bits of a mixed node's header: the state of a child.
fn voxel_child(header: u32, child: u32) -> u32 {
    return (header >> (2u * child)) & 3u;
}

// The pointer of a mixed child; those of mixed children stand in their order behind the header.
fn voxel_pointer(node: VoxelNode, header: u32, child: u32) -> u32 {
    return voxel_word(node.at + 1u + countOneBits(header & 0xaaaau & ((1u << (2u * child)) - 1u)));
}

// From a mixed node above level 3 to its child over a voxel.
fn voxel_descend(v: VoxelParams, node: VoxelNode, voxel: vec3u) -> VoxelNode {
    let level = node.level - 1u;
    let bits = (voxel >> vec3u(level)) & vec3u(1u);
    let child = bits.x << 2u | bits.y << 1u | bits.z;
    let header = voxel_word(node.at);
    let state = voxel_child(header, child);
    if (state < VOXEL_MIXED) {
        return VoxelNode(state, level, 0u);
    }
    return VoxelNode(VOXEL_MIXED, level, v.places.x + voxel_pointer(node, header, child));
}

// Lit bits of a mask in a slab of a mixed node of level 3.
fn voxel_slab_bits(v: VoxelParams, node: VoxelNode, z: u32, mask: vec2u) -> vec2u {
    let header = voxel_word(node.at);
    let state = voxel_child(header, z);
    if (state < VOXEL_MIXED) {
        return state * mask;
    }
    return voxel_slab_words(v, voxel_pointer(node, header, z), mask);
}
