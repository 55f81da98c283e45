// Nodes of a light-aligned graph in the packed layout; the counterpart of adumbra_papers::dag::packed, which
// documents the bits and the sources. Words: top, units and shared leaf masks are concatenated as they are in
// the file, the latter two from `extra.x` and `code_offset` on. A node's position is that of its first unit.

// States of a quarter's nearer and farther child by the quarter's code, two bits per code.
const ADUMBRA_PACKED_NEARER: u32 = 0x2994u;
const ADUMBRA_PACKED_FARTHER: u32 = 0x2284u;
const ADUMBRA_PACKED_TWO_MIXED: u32 = 3u;
// Value of the header's follower field if every pointer has a slot.
const ADUMBRA_PACKED_NO_FOLLOWER: u32 = 7u;

fn adumbra_packed_unit(v: AdumbraVoxelParams, at: u32) -> u32 {
    return (adumbra_voxel_word(v.extra.x + (at >> 1u)) >> (16u * (at & 1u))) & 0xffffu;
}

// Returns two units, the lower one in the low half.
fn adumbra_packed_two_units(v: AdumbraVoxelParams, at: u32) -> u32 {
    let word = v.extra.x + (at >> 1u);
    if ((at & 1u) == 0u) {
        return adumbra_voxel_word(word);
    }
    return (adumbra_voxel_word(word) >> 16u) | (adumbra_voxel_word(word + 1u) << 16u);
}

// Returns the unit at which a level's pool begins. It ends where the pool of the level above begins.
fn adumbra_packed_pool(level: u32) -> u32 {
    return adumbra_voxel_word(level - 3u);
}

// Returns the number of pointers of the quarters with these codes, three bits each.
fn adumbra_packed_pointers(codes: u32) -> u32 {
    return countOneBits(codes & 0x924u) + 2u * countOneBits(codes & (codes >> 1u) & 0x249u);
}

// Returns the width in bits of a wide slot's high part, given the number of units in the target pool.
fn adumbra_packed_high_bits(pool_units: u32) -> u32 {
    return select(select(16u, 8u, pool_units <= 0x1000000u), 4u, pool_units <= 0x100000u);
}

fn adumbra_voxel_root(v: AdumbraVoxelParams, voxel: vec3u) -> AdumbraVoxelNode {
    let level = v.root_level;
    let root = voxel >> vec3u(level);
    let column = ADUMBRA_PACKED_POOL_WORDS + 2u * (root.y * v.root_count.x + root.x);
    let first_mixed_z = adumbra_voxel_word(column + 1u);
    if (root.z < first_mixed_z) {
        return AdumbraVoxelNode(1u, level, 0u);
    }
    let index = adumbra_voxel_word(column) + (root.z - first_mixed_z);
    if (index >= adumbra_voxel_word(column + 2u)) {
        return AdumbraVoxelNode(0u, level, 0u);
    }
    let roots = ADUMBRA_PACKED_POOL_WORDS + 2u * v.root_count.x * v.root_count.y + 1u;
    return AdumbraVoxelNode(ADUMBRA_VOXEL_MIXED, level, adumbra_packed_pool(level) + adumbra_voxel_word(roots + index));
}

// Returns the unit that a pointer of a node above level 3 leads to.
fn adumbra_packed_target(v: AdumbraVoxelParams, node: AdumbraVoxelNode, header: u32, pointer: u32) -> u32 {
    let follower = extractBits(header, 12u, 3u);
    let has_follower = follower != ADUMBRA_PACKED_NO_FOLLOWER;
    let slots = adumbra_packed_pointers(header & 0xfffu) - u32(has_follower);
    var slots_at = node.at + 1u;
    var is_wide = false;
    var high = 0u;
    if ((header >> 15u) == 1u) {
        let wide = adumbra_packed_unit(v, node.at + 1u) & 0xffu;
        let width = adumbra_packed_high_bits(adumbra_packed_pool(node.level) - adumbra_packed_pool(node.level - 1u));
        let front = max(width, 8u);
        slots_at += (front + width * countOneBits(wide) + 15u) >> 4u;
        is_wide = extractBits(wide, pointer, 1u) == 1u;
        if (is_wide) {
            let bit = front + width * countOneBits(wide & ((1u << pointer) - 1u));
            high = extractBits(adumbra_packed_unit(v, node.at + 1u + (bit >> 4u)), bit & 15u, width);
        }
    }
    // The header never names an eighth pointer.
    if (pointer == follower && has_follower) {
        return slots_at + slots;
    }
    let value = adumbra_packed_unit(v, slots_at + pointer - u32(pointer > follower));
    if (is_wide) {
        return adumbra_packed_pool(node.level - 1u) + ((high << 16u) | value);
    }
    if (value < ADUMBRA_PACKED_NEAR_UNITS) {
        return slots_at + slots + value;
    }
    return adumbra_packed_pool(node.level - 1u) + value - ADUMBRA_PACKED_NEAR_UNITS;
}

fn adumbra_voxel_descend(v: AdumbraVoxelParams, node: AdumbraVoxelNode, voxel: vec3u) -> AdumbraVoxelNode {
    let level = node.level - 1u;
    let bits = (voxel >> vec3u(level)) & vec3u(1u);
    let quarter_at = 3u * ((bits.x << 1u) | bits.y);
    let header = adumbra_packed_unit(v, node.at);
    let code = extractBits(header, quarter_at, 3u);
    let is_farther = bits.z == 1u;
    let state = extractBits(select(ADUMBRA_PACKED_NEARER, ADUMBRA_PACKED_FARTHER, is_farther), 2u * code, 2u);
    if (state < ADUMBRA_VOXEL_MIXED) {
        return AdumbraVoxelNode(state, level, 0u);
    }
    let before = adumbra_packed_pointers(header & ((1u << quarter_at) - 1u));
    let pointer = before + u32(is_farther && code == ADUMBRA_PACKED_TWO_MIXED);
    return AdumbraVoxelNode(ADUMBRA_VOXEL_MIXED, level, adumbra_packed_target(v, node, header, pointer));
}

// Returns the lit bits of `mask` in the leaf mask stored in the four units at `at`.
fn adumbra_packed_look_up(v: AdumbraVoxelParams, at: u32, mask: vec2u) -> vec2u {
    var lit = vec2u(0u);
    if (mask.x != 0u) {
        lit.x = adumbra_packed_two_units(v, at) & mask.x;
    }
    if (mask.y != 0u) {
        lit.y = adumbra_packed_two_units(v, at + 2u) & mask.y;
    }
    return lit;
}

// Returns the lit bits of `mask` in leaf mask z of a node of level 3. A half in which `mask` is zero is not
// read.
fn adumbra_voxel_look_up(v: AdumbraVoxelParams, node: AdumbraVoxelNode, z: u32, mask: vec2u) -> vec2u {
    let header = adumbra_packed_unit(v, node.at);
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
        // A column is lit in this mask if it is lit in at least `change` masks. Plane b holds bit b of the
        // columns' counts.
        let planes = 32u - countLeadingZeros(masks);
        var lit = mask;
        for (var bit = 0u; bit < planes; bit++) {
            let plane = adumbra_packed_look_up(v, follow + 4u * bit, mask);
            lit = select(lit | plane, lit & plane, extractBits(change, bit, 1u) == 1u);
        }
        return lit;
    }
    // Masks 5, 6 and 7 share one bit.
    let flags = extractBits(header, 9u, 6u);
    let here = flags | ((flags & 0x20u) * 6u);
    let index = change - 1u;
    let at = follow + index + 3u * countOneBits(here & ((1u << index) - 1u));
    if (extractBits(here, index, 1u) == 1u) {
        return adumbra_packed_look_up(v, at, mask);
    }
    return adumbra_leaf_mask_look_up(v, adumbra_packed_unit(v, at), mask);
}
