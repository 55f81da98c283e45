// Look-up in a light-aligned graph with K × K texels; the twin of adumbra::query, and the same to the last tap. All taps in one block
// of 8 × 8 texels share one layer of voxels, so K = 3 to 9 reads at most 4 slabs, K = 17 at most 9. Source: as core/voxel.wgsl, which
// goes before it. The layout is that of core/voxel_plain.wgsl or core/voxel_packed.wgsl, which define
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

// Lit bits of a mask in the slab of 8 × 8 voxels that holds this one, below a node that does: bit y·8 + x, rows 0 to 3 in x.
fn voxel_lit_bits(v: VoxelParams, over: VoxelNode, voxel: vec3u, mask: vec2u) -> u32 {
    var node = over;
    if (node.state == VOXEL_UNKNOWN) {
        node = voxel_root(v, voxel);
    }
    while (node.state == VOXEL_MIXED && node.level > 3u) {
        node = voxel_descend(v, node, voxel);
    }
    var lit = select(vec2u(0u), mask, node.state == 1u);
    if (node.state == VOXEL_MIXED) {
        lit = voxel_slab_bits(v, node, voxel.z & 7u, mask);
    }
    return countOneBits(lit.x) + countOneBits(lit.y);
}

// Lit taps among the texels low…high, which lie in one block.
fn voxel_block(v: VoxelParams, r: VoxelReceiver, over: VoxelNode, low: vec2i, high: vec2i) -> u32 {
    let taps = voxel_taps(v, r, low, high);
    if (taps.layer < 0) {
        return taps.beside;
    }
    let mask = voxel_rectangle(taps.low, taps.high);
    return taps.beside + voxel_lit_bits(v, over, vec3u(vec3i(taps.low, taps.layer)), mask);
}

// Lit taps of K².
fn voxel_lit_taps(v: VoxelParams, r: VoxelReceiver) -> u32 {
    let reach = i32(v.places.z >> 1u);
    let texel = r.p_fixed.xy >> vec2u(FIXED_BITS);
    let low = texel - reach;
    let high = texel + reach;
    // The box of all voxels that are read: the first and the last block have the outermost layers.
    let rises = r.gradient >= vec2i(0);
    let first_layer = voxel_layer(r, select(high, low, rises));
    let last_layer = voxel_layer(r, select(min(low | vec2i(7), high), max(high & vec2i(-8), low), rises));
    let last = v.grid.size.xyz - 1;
    let box_low = clamp(vec3i(low, first_layer), vec3i(0), last);
    let box_high = clamp(vec3i(high, last_layer), vec3i(0), last);
    let over = voxel_over(v, vec3u(box_low), vec3u(box_high));
    // What lies beside the grid or before it is lit too.
    if (over.state == 1u) {
        return v.places.z * v.places.z;
    }
    if (over.state == 0u && first_layer >= 0 && all(low >= vec2i(0)) && all(high <= last.xy)) {
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
