// Look-up in a light-aligned graph with K × K texels; the twin of adumbra::query, and the same to the last tap. Taps are gathered by block
// of 8 × 8 texels, at most 4 for K = 3 to 9 and 9 for K = 17: a way down for each eight layers that a block's taps lie in, a slab for each
// layer. Source: as core/voxel.wgsl, which goes before it. The layout is that of core/voxel_plain.wgsl or core/voxel_packed.wgsl, which define
//   fn voxel_root(v: VoxelParams, voxel: vec3u) -> VoxelNode: the root over a voxel;
//   fn voxel_descend(v: VoxelParams, node: VoxelNode, voxel: vec3u) -> VoxelNode: from a mixed node above level 3 to its child;
//   fn voxel_slab_bits(v: VoxelParams, node: VoxelNode, z: u32, mask: vec2u) -> vec2u: a mask's lit bits in slab z of a mixed node of
//   level 3.

const VOXEL_MIXED: u32 = 2u;
const VOXEL_UNKNOWN: u32 = 3u;

// What holds a box of voxels: a node of this level, or all shadowed (0), all lit (1); or no root holds it all.
struct VoxelNode {
    state: u32,
    level: u32,
    // Where the node lies, as its layout counts.
    at: u32,
}

// The deepest node of level 3 and more that holds all voxels low…high, so that paths to several of them share their beginning.
fn voxel_over(v: VoxelParams, low: vec3u, high: vec3u) -> VoxelNode {
    let differs = low ^ high;
    let shared_level = max(32u - countLeadingZeros(differs.x | differs.y | differs.z), 3u);
    if (shared_level > v.top_dims.w) {
        return VoxelNode(VOXEL_UNKNOWN, 0u, 0u);
    }
    var node = voxel_root(v, low);
    while (node.state == VOXEL_MIXED && node.level > shared_level) {
        node = voxel_descend(v, node, low);
    }
    return node;
}

// Lit bits of a mask in a slab of the file; half a slab that the mask lacks is not read.
fn voxel_slab_words(v: VoxelParams, index: u32, mask: vec2u) -> vec2u {
    let slab = v.places.y + 2u * index;
    var lit = vec2u(0u);
    if (mask.x != 0u) {
        lit.x = voxel_word(slab) & mask.x;
    }
    if (mask.y != 0u) {
        lit.y = voxel_word(slab + 1u) & mask.y;
    }
    return lit;
}

// The node of level 3 that holds a voxel, below a node that does, or what holds it and is all alike.
fn voxel_cube(v: VoxelParams, over: VoxelNode, voxel: vec3u) -> VoxelNode {
    var node = over;
    if (node.state == VOXEL_UNKNOWN) {
        node = voxel_root(v, voxel);
    }
    while (node.state == VOXEL_MIXED && node.level > 3u) {
        node = voxel_descend(v, node, voxel);
    }
    return node;
}

// Lit taps among the texels low…high, which lie in one block.
fn voxel_block(v: VoxelParams, r: VoxelReceiver, over: VoxelNode, low: vec2i, high: vec2i) -> u32 {
    let taps = voxel_taps(v, r, low, high);
    if (taps.farthest < 0) {
        return taps.beside;
    }
    // What was counted: all before the grid is lit.
    var counted = vec2u(0u);
    if (taps.nearest < 0) {
        counted = voxel_taps_to(r, taps, -1);
    }
    var lit = taps.beside + voxel_count(counted);
    var layer = max(taps.nearest, 0);
    while (layer <= taps.farthest) {
        let cube = voxel_cube(v, over, vec3u(vec3i(taps.low, layer)));
        let is_mixed = cube.state == VOXEL_MIXED;
        // A cube that is all alike answers all its layers at once.
        let last = min(layer | 7, taps.farthest);
        for (var to = select(last, layer, is_mixed); to <= last; to++) {
            let up_to = voxel_taps_to(r, taps, to);
            let mask = up_to & ~counted;
            if (is_mixed && any(mask != vec2u(0u))) {
                lit += voxel_count(voxel_slab_bits(v, cube, u32(to) & 7u, mask));
            } else {
                lit += select(0u, voxel_count(mask), cube.state == 1u);
            }
            counted = up_to;
        }
        layer = last + 1;
    }
    return lit;
}

// Lit taps of K².
fn voxel_lit_taps(v: VoxelParams, r: VoxelReceiver) -> u32 {
    let reach = i32(v.places.z >> 1u);
    let texel = r.p_fixed.xy >> vec2u(FIXED_BITS);
    let low = texel - reach;
    let high = texel + reach;
    // The box of all voxels that are read.
    let rises = r.gradient >= vec2i(0);
    let nearest = voxel_layer(r, select(high, low, rises));
    let last = v.grid.size.xyz - 1;
    var farthest_tap = select(low, high, rises);
    if (v.places.w == 1u) {
        // The nearest of the last block.
        farthest_tap = select(min(min(low | vec2i(7), high), last.xy), max(high & vec2i(-8), low), rises);
    }
    let farthest = voxel_layer(r, farthest_tap);
    let box_low = clamp(vec3i(low, nearest), vec3i(0), last);
    let box_high = clamp(vec3i(high, farthest), vec3i(0), last);
    let over = voxel_over(v, vec3u(box_low), vec3u(box_high));
    // What lies beside the grid or before it is lit too.
    if (over.state == 1u) {
        return v.places.z * v.places.z;
    }
    if (over.state == 0u && nearest >= 0 && all(low >= vec2i(0)) && all(high <= last.xy)) {
        return 0u;
    }
    var lit = 0u;
    for (var y = low.y; y <= high.y; y = (y | 7) + 1) {
        for (var x = low.x; x <= high.x; x = (x | 7) + 1) {
            lit += voxel_block(v, r, over, vec2i(x, y), min(vec2i(x, y) | vec2i(7), high));
        }
    }
    return lit;
}

fn voxel_factor(v: VoxelParams, s: Surface) -> f32 {
    return f32(voxel_lit_taps(v, voxel_receiver(v, s))) / f32(v.places.z * v.places.z);
}
