// Look-up in a light-aligned graph with K × K texels; the counterpart of adumbra::query, with the same result for every
// tap. Taps are gathered by blocks of 8 × 8 texels, at most 4 blocks for K = 3 to 9 and 9 for K = 17. Each block takes
// one descent per eight layers that its taps are in, and one leaf mask per layer.
// Source: see core/voxel.wgsl, which must precede this file.
// The layout is that of core/voxel_plain.wgsl or core/voxel_packed.wgsl, which define
//     fn adumbra_voxel_root(v: AdumbraVoxelParams, voxel: vec3u) -> AdumbraVoxelNode
// The root that contains a voxel.
//     fn adumbra_voxel_descend(v: AdumbraVoxelParams, node: AdumbraVoxelNode, voxel: vec3u) -> AdumbraVoxelNode
// From a mixed node above level 3 to the child that contains a voxel.
//     fn adumbra_voxel_look_up(v: AdumbraVoxelParams, node: AdumbraVoxelNode, z: u32, mask: vec2u) -> vec2u
// The lit bits of a mask in leaf mask z of a mixed node of level 3.

const ADUMBRA_VOXEL_MIXED: u32 = 2u;
const ADUMBRA_VOXEL_UNKNOWN: u32 = 3u;

// The node that contains a box of voxels: a node of this level, or all shadowed (0) or all lit (1). It is unknown if no
// single root contains the box.
struct AdumbraVoxelNode {
    state: u32,
    level: u32,
    // Position of the node, in the units of its layout.
    at: u32,
}

// Returns the deepest node of level 3 or higher that contains all voxels low…high, so that look-ups of several of them
// share the first part of the descent.
fn adumbra_voxel_over(v: AdumbraVoxelParams, low: vec3u, high: vec3u) -> AdumbraVoxelNode {
    let differs = low ^ high;
    let shared_level = max(32u - countLeadingZeros(differs.x | differs.y | differs.z), 3u);
    if (shared_level > v.root_level) {
        return AdumbraVoxelNode(ADUMBRA_VOXEL_UNKNOWN, 0u, 0u);
    }
    var node = adumbra_voxel_root(v, low);
    while (node.state == ADUMBRA_VOXEL_MIXED && node.level > shared_level) {
        node = adumbra_voxel_descend(v, node, low);
    }
    return node;
}

// Returns the lit bits of `mask` in a leaf mask of the file. A half in which `mask` is zero is not read.
fn adumbra_leaf_mask_look_up(v: AdumbraVoxelParams, index: u32, mask: vec2u) -> vec2u {
    let word = v.masks_offset + 2u * index;
    var lit = vec2u(0u);
    if (mask.x != 0u) {
        lit.x = adumbra_voxel_word(word) & mask.x;
    }
    if (mask.y != 0u) {
        lit.y = adumbra_voxel_word(word + 1u) & mask.y;
    }
    return lit;
}

// Returns the node of level 3 that contains a voxel, or the uniform node that does, starting from an ancestor.
fn adumbra_voxel_leaf_node(v: AdumbraVoxelParams, trail: AdumbraVoxelNode, voxel: vec3u) -> AdumbraVoxelNode {
    var node = trail;
    if (node.state == ADUMBRA_VOXEL_UNKNOWN) {
        node = adumbra_voxel_root(v, voxel);
    }
    while (node.state == ADUMBRA_VOXEL_MIXED && node.level > 3u) {
        node = adumbra_voxel_descend(v, node, voxel);
    }
    return node;
}

// Counts the lit taps among the texels low…high, which lie in one block.
fn adumbra_voxel_block(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, trail: AdumbraVoxelNode, low: vec2i, high: vec2i) -> u32 {
    let taps = adumbra_voxel_taps(v, r, low, high);
    if (taps.farthest < 0) {
        return taps.beside;
    }
    // Taps counted so far. All taps in front of the grid are lit.
    var counted = vec2u(0u);
    if (taps.nearest < 0) {
        counted = adumbra_voxel_taps_to(r, taps, -1);
    }
    var lit = taps.beside + adumbra_voxel_count(counted);
    var layer = max(taps.nearest, 0);
    while (layer <= taps.farthest) {
        let cube = adumbra_voxel_leaf_node(v, trail, vec3u(vec3i(taps.low, layer)));
        let is_mixed = cube.state == ADUMBRA_VOXEL_MIXED;
        // A uniform cube resolves all its layers at once.
        let last = min(layer | 7, taps.farthest);
        for (var to = select(last, layer, is_mixed); to <= last; to++) {
            let up_to = adumbra_voxel_taps_to(r, taps, to);
            let mask = up_to & ~counted;
            if (is_mixed && any(mask != vec2u(0u))) {
                lit += adumbra_voxel_count(adumbra_voxel_look_up(v, cube, u32(to) & 7u, mask));
            } else {
                lit += select(0u, adumbra_voxel_count(mask), cube.state == 1u);
            }
            counted = up_to;
        }
        layer = last + 1;
    }
    return lit;
}

// Counts the lit taps of the K² filter.
fn adumbra_voxel_lit_taps(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver) -> u32 {
    let reach = i32(v.filter_width >> 1u);
    let texel = r.p_fixed.xy >> vec2u(ADUMBRA_FIXED_BITS);
    let low = texel - reach;
    let high = texel + reach;
    // Bounding box of all voxels that are read.
    let rises = r.gradient >= vec2i(0);
    let nearest = adumbra_voxel_layer(r, select(high, low, rises));
    let last = v.grid.size - 1;
    var farthest_tap = select(low, high, rises);
    if (v.taps_share_layer == 1u) {
        // The nearest tap of the farthest block.
        farthest_tap = select(min(min(low | vec2i(7), high), last.xy), max(high & vec2i(-8), low), rises);
    }
    let farthest = adumbra_voxel_layer(r, farthest_tap);
    let box_low = clamp(vec3i(low, nearest), vec3i(0), last);
    let box_high = clamp(vec3i(high, farthest), vec3i(0), last);
    let trail = adumbra_voxel_over(v, vec3u(box_low), vec3u(box_high));
    // Everything beside or in front of the grid is lit too.
    if (trail.state == 1u) {
        return v.filter_width * v.filter_width;
    }
    if (trail.state == 0u && nearest >= 0 && all(low >= vec2i(0)) && all(high <= last.xy)) {
        return 0u;
    }
    var lit = 0u;
    for (var y = low.y; y <= high.y; y = (y | 7) + 1) {
        for (var x = low.x; x <= high.x; x = (x | 7) + 1) {
            lit += adumbra_voxel_block(v, r, trail, vec2i(x, y), min(vec2i(x, y) | vec2i(7), high));
        }
    }
    return lit;
}
