// Nodes of a light-aligned graph in the packed layout; the twin of adumbra::dag::packed, whose text has the bits and the sources.
// Words: top, units and shared slabs one behind the other, as they are in the file, the latter two from `places.x` and `places.y` on.
// A node is where its first unit is.

// How a code of a quarter says what its nearer and its farther child are: two bits a code.
const PACKED_NEARER: u32 = 0x2994u;
const PACKED_FARTHER: u32 = 0x2284u;
const PACKED_TWO_MIXED: u32 = 3u;
// In place of the pointer that has no slot: all have one.
const PACKED_NO_FOLLOWER: u32 = 7u;

fn packed_unit(v: VoxelParams, at: u32) -> u32 {
    return (voxel_word(v.places.x + (at >> 1u)) >> (16u * (at & 1u))) & 0xffffu;
}

// Two units, the lower first.
fn packed_two_units(v: VoxelParams, at: u32) -> u32 {
    let word = v.places.x + (at >> 1u);
    if ((at & 1u) == 0u) {
        return voxel_word(word);
    }
    return (voxel_word(word) >> 16u) | (voxel_word(word + 1u) << 16u);
}

// Unit where a level's pool begins; that of the level above is where it ends.
fn packed_pool(level: u32) -> u32 {
    return voxel_word(level - 3u);
}

// Pointers of quarters, three bits each.
fn packed_pointers(codes: u32) -> u32 {
    return countOneBits(codes & 0x924u) + 2u * countOneBits(codes & (codes >> 1u) & 0x249u);
}

// Bits of a wide slot's high part, where the pool that it leads to has so many units.
fn packed_high_bits(pool_units: u32) -> u32 {
    return select(select(16u, 8u, pool_units <= 0x1000000u), 4u, pool_units <= 0x100000u);
}

fn voxel_root(v: VoxelParams, voxel: vec3u) -> VoxelNode {
    let level = v.top_dims.w;
    let root = voxel >> vec3u(level);
    let column = PACKED_POOL_WORDS + 2u * (root.y * v.top_dims.x + root.x);
    let first_mixed_z = voxel_word(column + 1u);
    if (root.z < first_mixed_z) {
        return VoxelNode(1u, level, 0u);
    }
    let index = voxel_word(column) + (root.z - first_mixed_z);
    if (index >= voxel_word(column + 2u)) {
        return VoxelNode(0u, level, 0u);
    }
    let roots = PACKED_POOL_WORDS + 2u * v.top_dims.x * v.top_dims.y + 1u;
    return VoxelNode(VOXEL_MIXED, level, packed_pool(level) + voxel_word(roots + index));
}

// The unit that a pointer of a node above level 3 leads to.
fn packed_target(v: VoxelParams, node: VoxelNode, header: u32, pointer: u32) -> u32 {
    let follower = extractBits(header, 12u, 3u);
    let has_follower = follower != PACKED_NO_FOLLOWER;
    let slots = packed_pointers(header & 0xfffu) - u32(has_follower);
    var slots_at = node.at + 1u;
    var is_wide = false;
    var high = 0u;
    if ((header >> 15u) == 1u) {
        let wide = packed_unit(v, node.at + 1u) & 0xffu;
        let width = packed_high_bits(packed_pool(node.level) - packed_pool(node.level - 1u));
        let front = max(width, 8u);
        slots_at += (front + width * countOneBits(wide) + 15u) >> 4u;
        is_wide = extractBits(wide, pointer, 1u) == 1u;
        if (is_wide) {
            let place = front + width * countOneBits(wide & ((1u << pointer) - 1u));
            high = extractBits(packed_unit(v, node.at + 1u + (place >> 4u)), place & 15u, width);
        }
    }
    // An eighth pointer is never the one that the header names.
    if (pointer == follower && has_follower) {
        return slots_at + slots;
    }
    let value = packed_unit(v, slots_at + pointer - u32(pointer > follower));
    if (is_wide) {
        return packed_pool(node.level - 1u) + ((high << 16u) | value);
    }
    if (value < PACKED_NEAR_UNITS) {
        return slots_at + slots + value;
    }
    return packed_pool(node.level - 1u) + value - PACKED_NEAR_UNITS;
}

fn voxel_descend(v: VoxelParams, node: VoxelNode, voxel: vec3u) -> VoxelNode {
    let level = node.level - 1u;
    let bits = (voxel >> vec3u(level)) & vec3u(1u);
    let quarter_at = 3u * ((bits.x << 1u) | bits.y);
    let header = packed_unit(v, node.at);
    let code = extractBits(header, quarter_at, 3u);
    let is_farther = bits.z == 1u;
    let state = extractBits(select(PACKED_NEARER, PACKED_FARTHER, is_farther), 2u * code, 2u);
    if (state < VOXEL_MIXED) {
        return VoxelNode(state, level, 0u);
    }
    let before = packed_pointers(header & ((1u << quarter_at) - 1u));
    let pointer = before + u32(is_farther && code == PACKED_TWO_MIXED);
    return VoxelNode(VOXEL_MIXED, level, packed_target(v, node, header, pointer));
}

// Lit bits of a mask among the four units of another one.
fn packed_mask_bits(v: VoxelParams, at: u32, mask: vec2u) -> vec2u {
    var lit = vec2u(0u);
    if (mask.x != 0u) {
        lit.x = packed_two_units(v, at) & mask.x;
    }
    if (mask.y != 0u) {
        lit.y = packed_two_units(v, at + 2u) & mask.y;
    }
    return lit;
}

// Lit bits of a mask in a slab of a node of level 3; half a slab that the mask lacks is not read.
fn voxel_slab_bits(v: VoxelParams, node: VoxelNode, z: u32, mask: vec2u) -> vec2u {
    let header = packed_unit(v, node.at);
    let masks = countOneBits(header & 0xffu) - extractBits(header, 8u, 1u);
    let change = countOneBits(header & ((2u << z) - 1u));
    if (change == 0u) {
        return mask;
    }
    if (change > masks) {
        return vec2u(0u);
    }
    let follow = node.at + 1u;
    if ((header >> 15u) == 1u) {
        // Columns lit in at least as many masks as this one's number: plane b is bit b of their counts.
        let planes = 32u - countLeadingZeros(masks);
        var lit = mask;
        for (var bit = 0u; bit < planes; bit++) {
            let plane = packed_mask_bits(v, follow + 4u * bit, mask);
            lit = select(lit | plane, lit & plane, extractBits(change, bit, 1u) == 1u);
        }
        return lit;
    }
    // Masks 5, 6 and 7 share a bit.
    let flags = extractBits(header, 9u, 6u);
    let here = flags | ((flags & 0x20u) * 6u);
    let index = change - 1u;
    let at = follow + index + 3u * countOneBits(here & ((1u << index) - 1u));
    if (extractBits(here, index, 1u) == 1u) {
        return packed_mask_bits(v, at, mask);
    }
    return voxel_slab_words(v, packed_unit(v, at), mask);
}
