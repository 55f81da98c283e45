// Look-up in a light-aligned graph with K × K texels; the twin of adumbra::query, and the same to the last tap. All taps in one block
// of 8 × 8 texels share one layer of voxels, so K = 3 to 9 reads at most 4 slabs, K = 17 at most 9. Source: Sintorn, Kämpe, Olsson,
// Assarsson, Compact Precomputed Voxelized Shadows, 2014; spec/adumbra-file.md has graph and filter.
// Words come through `fn voxel_word(index: u32) -> u32` of an access/ file: top, nodes and slabs one behind the other.

struct VoxelReceiver {
    p_fixed: vec3i,
    gradient: vec2i,
}

// The point after its bias, with its plane's slope.
fn voxel_receiver(v: VoxelParams, s: Surface) -> VoxelReceiver {
    let n = grid_direction(v.grid, s.normal);
    let tangent = length(n.xy);
    // n·l is -n.z: the grid's z runs away from the sun.
    let n_dot_l = max(-n.z, tangent / MAX_SLOPE);
    var gradient = vec2f(0.0);
    var slope = 0.0;
    if (n_dot_l > 0.0) {
        gradient = n.xy / n_dot_l;
        slope = min(tangent / n_dot_l, MAX_SLOPE);
    }
    let lift = n * v.bias.z - vec3f(0.0, 0.0, bias_along_light(v.bias, slope));
    var r: VoxelReceiver;
    r.p_fixed = grid_fixed(v.grid, grid_position(v.grid, s.p_relative), lift);
    let rounded = vec2i(floor(gradient * f32(GRADIENT_ONE) + 0.5));
    r.gradient = clamp(rounded, vec2i(-MAX_GRADIENT), vec2i(MAX_GRADIENT));
    return r;
}

const VOXEL_MIXED: u32 = 2u;
const VOXEL_UNKNOWN: u32 = 3u;

// What holds a box of voxels: a node of this level, or all shadowed (0), all lit (1); or no root holds it all.
struct VoxelNode {
    state: u32,
    level: u32,
    // Index of the node's header.
    at: u32,
}

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

// Lit bits of a mask in the slab of 8 × 8 voxels that holds this one, below a node that does: bit y·8 + x, rows 0 to 3 in x.
fn voxel_lit_bits(v: VoxelParams, over: VoxelNode, voxel: vec3u, mask: vec2u) -> u32 {
    var node = over;
    if (node.state == VOXEL_UNKNOWN) {
        node = voxel_root(v, voxel);
    }
    while (node.state == VOXEL_MIXED && node.level > 3u) {
        node = voxel_descend(v, node, voxel);
    }
    var state = node.state;
    if (state == VOXEL_MIXED) {
        let child = voxel.z & 7u;
        let header = voxel_word(node.at);
        state = voxel_child(header, child);
        if (state == VOXEL_MIXED) {
            let slab = v.places.y + 2u * voxel_pointer(node, header, child);
            var lit = 0u;
            if (mask.x != 0u) {
                lit = countOneBits(voxel_word(slab) & mask.x);
            }
            if (mask.y != 0u) {
                lit += countOneBits(voxel_word(slab + 1u) & mask.y);
            }
            return lit;
        }
    }
    return state * (countOneBits(mask.x) + countOneBits(mask.y));
}

// Bits of the texels low…high, which lie in one block.
fn voxel_rectangle(low: vec2i, high: vec2i) -> vec2u {
    let x = vec2u(u32(low.x) & 7u, u32(high.x) & 7u);
    let y = vec2u(u32(low.y) & 7u, u32(high.y) & 7u);
    let rows = ((2u << (x.y - x.x)) - 1u) << x.x;
    let all = rows * 0x01010101u;
    let lower = min(vec2u(y.x, y.y + 1u), vec2u(4u));
    let upper = max(vec2u(y.x, y.y + 1u), vec2u(4u)) - 4u;
    return vec2u(
        insertBits(0u, all, 8u * lower.x, 8u * (lower.y - lower.x)),
        insertBits(0u, all, 8u * upper.x, 8u * (upper.y - upper.x)),
    );
}

// The layer of the receiver's plane at the centre of a tap.
fn voxel_layer(r: VoxelReceiver, tap: vec2i) -> i32 {
    let along = r.gradient * (tap * FIXED_ONE + FIXED_ONE / 2 - r.p_fixed.xy);
    return (r.p_fixed.z + ((along.x + along.y) >> GRADIENT_BITS)) >> FIXED_BITS;
}

// Lit taps among the texels low…high, which lie in one block. Their layer is that of the plane at their centre less half its slope times
// their extent, which is that at the tap where the plane is nearest to the sun.
fn voxel_block(v: VoxelParams, r: VoxelReceiver, over: VoxelNode, low: vec2i, high: vec2i) -> u32 {
    let size = high - low + 1;
    let count = u32(size.x * size.y);
    // Texels beside the grid are lit.
    let inside_low = max(low, vec2i(0));
    let inside_high = min(high, v.grid.size.xy - 1);
    let layer = voxel_layer(r, select(high, low, r.gradient >= vec2i(0)));
    if (any(inside_low > inside_high) || layer < 0) {
        return count;
    }
    let inside = inside_high - inside_low + 1;
    let mask = voxel_rectangle(inside_low, inside_high);
    let voxel = vec3u(vec3i(inside_low, min(layer, v.grid.size.z - 1)));
    return count - u32(inside.x * inside.y) + voxel_lit_bits(v, over, voxel, mask);
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
