// Look-up in a light-aligned graph with K × K texels; the counterpart of adumbra_papers::dag::DagQuery, with
// the same result for every tap. Taps are gathered by blocks of 8 × 8 texels, at most 4 blocks for K = 3 to 9
// and 9 for K = 17. Every bake makes columns that switch from lit to shadowed once. So a column that is lit
// in the farthest layer of a block's taps is lit for all of them, and a column that is shadowed in the
// nearest layer is shadowed for all. Only columns that switch in between are looked up layer by layer.
// Source: see core/voxel.wgsl, which must precede this file. The layout is that of core/voxel_plain.wgsl or
// core/voxel_packed.wgsl, which define
//     fn adumbra_voxel_root(v: AdumbraVoxelParams, voxel: vec3u) -> AdumbraVoxelNode
// The root that contains a voxel.
//     fn adumbra_voxel_descend(v: AdumbraVoxelParams, node: AdumbraVoxelNode, voxel: vec3u)
//         -> AdumbraVoxelNode
// From a mixed node above level 3 to the child that contains a voxel.
//     fn adumbra_voxel_look_up(v: AdumbraVoxelParams, node: AdumbraVoxelNode, z: u32, mask: vec2u) -> vec2u
// The lit bits of a mask in leaf mask z of a mixed node of level 3.

const ADUMBRA_VOXEL_MIXED: u32 = 2u;
const ADUMBRA_VOXEL_UNKNOWN: u32 = 3u;

// The node that contains a box of voxels: a node of this level, or all shadowed (0) or all lit (1). It is
// unknown if no single root contains the box.
struct AdumbraVoxelNode {
    state: u32,
    level: u32,
    // Position of the node, in the units of its layout.
    at: u32,
}

// Returns the deepest node of level 3 or higher that contains all voxels low…high, so that look-ups of
// several of them share the first part of the descent. It is below `trail`, which contains them too, or
// unknown.
fn adumbra_voxel_over(v: AdumbraVoxelParams, trail: AdumbraVoxelNode, low: vec3u, high: vec3u) -> AdumbraVoxelNode {
    let differs = low ^ high;
    let shared_level = max(32u - countLeadingZeros(differs.x | differs.y | differs.z), 3u);
    if (shared_level > v.root_level) {
        return trail;
    }
    return adumbra_voxel_down(v, trail, low, shared_level);
}

// Descends from a node towards a voxel: to level `to_level`, or to a uniform node above it.
fn adumbra_voxel_down(v: AdumbraVoxelParams, trail: AdumbraVoxelNode, voxel: vec3u, to_level: u32) -> AdumbraVoxelNode {
    var node = trail;
    if (node.state == ADUMBRA_VOXEL_UNKNOWN) {
        node = adumbra_voxel_root(v, voxel);
    }
    while (node.state == ADUMBRA_VOXEL_MIXED && node.level > to_level) {
        node = adumbra_voxel_descend(v, node, voxel);
    }
    return node;
}

// Returns the lit bits of `mask` in a leaf mask of the file. A half in which `mask` is zero is not read.
fn adumbra_leaf_mask_look_up(v: AdumbraVoxelParams, index: u32, mask: vec2u) -> vec2u {
    let word = v.code_offset + 2u * index;
    var lit = vec2u(0u);
    if (mask.x != 0u) {
        lit.x = adumbra_voxel_word(word) & mask.x;
    }
    if (mask.y != 0u) {
        lit.y = adumbra_voxel_word(word + 1u) & mask.y;
    }
    return lit;
}

// Counts the lit taps among the texels low…high, which are in one block.
fn adumbra_voxel_block(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, trail: AdumbraVoxelNode, low: vec2i, high: vec2i) -> u32 {
    let taps = adumbra_voxel_taps(v, r, low, high);
    if (taps.farthest < 0) {
        return taps.beside;
    }
    let corner = vec2u(taps.low);
    let nearest = max(taps.nearest, 0);
    let node = adumbra_voxel_over(v, trail, vec3u(corner, u32(nearest)), vec3u(corner, u32(taps.farthest)));
    var lit = vec2u(0u);
    if (taps.nearest < 0) {
        // All taps in front of the grid are lit.
        lit = adumbra_voxel_taps_to(r, taps, -1);
    }
    // Taps that are not yet decided, and the farthest of their layers. The loop visits cubes of eight layers
    // towards the sun.
    var open = adumbra_voxel_rectangle(taps.low, taps.high) & ~lit;
    var layer = taps.farthest;
    while (layer >= nearest && any(open != vec2u(0u))) {
        let cube = adumbra_voxel_down(v, node, vec3u(corner, u32(layer)), 3u);
        let first = max(layer & -8, nearest);
        var before = vec2u(0u);
        if (first > nearest) {
            before = adumbra_voxel_taps_to(r, taps, first - 1);
        }
        if (cube.state == ADUMBRA_VOXEL_MIXED) {
            let found = adumbra_voxel_look_up(v, cube, u32(layer) & 7u, open);
            lit |= found;
            open &= ~found;
            lit |= adumbra_voxel_between(v, r, taps, cube, vec2i(first, layer), open & ~before);
        } else if (cube.state == 1u) {
            lit |= open;
            before = vec2u(0u);
        }
        open &= before;
        layer = first - 1;
    }
    return taps.beside + adumbra_voxel_count(lit);
}

// Returns the lit taps of `open`. These taps are in `layers` of a mixed cube and are shadowed in the last of
// the layers.
fn adumbra_voxel_between(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, taps: AdumbraVoxelTaps, cube: AdumbraVoxelNode, layers: vec2i, open: vec2u) -> vec2u {
    if (layers.x == layers.y || all(open == vec2u(0u))) {
        return vec2u(0u);
    }
    // Columns that are shadowed in the first layer are shadowed in all.
    var left = adumbra_voxel_look_up(v, cube, u32(layers.x) & 7u, open);
    var lit = left & adumbra_voxel_taps_to(r, taps, layers.x);
    left &= ~lit;
    for (var layer = layers.x + 1; layer < layers.y && any(left != vec2u(0u)); layer++) {
        let here = left & adumbra_voxel_taps_to(r, taps, layer);
        if (any(here != vec2u(0u))) {
            lit |= adumbra_voxel_look_up(v, cube, u32(layer) & 7u, here);
        }
        left &= ~here;
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
    let farthest = adumbra_voxel_layer(r, select(low, high, rises));
    let last = v.grid.size - 1;
    let box_low = clamp(vec3i(low, nearest), vec3i(0), last);
    let box_high = clamp(vec3i(high, farthest), vec3i(0), last);
    let unknown = AdumbraVoxelNode(ADUMBRA_VOXEL_UNKNOWN, 0u, 0u);
    let trail = adumbra_voxel_over(v, unknown, vec3u(box_low), vec3u(box_high));
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
