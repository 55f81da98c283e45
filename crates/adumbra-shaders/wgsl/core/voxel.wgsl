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

// The slab of 8 × 8 voxels that holds this one: bit y·8 + x, rows 0 to 3 in x.
fn voxel_slab(v: VoxelParams, voxel: vec3u) -> vec2u {
    var level = v.top_dims.w;
    let root = voxel >> vec3u(level);
    var word = voxel_word((root.z * v.top_dims.y + root.y) * v.top_dims.x + root.x);
    if (word >= TOP_SHADOWED) {
        return vec2u(select(0u, 0xffffffffu, word == TOP_LIT));
    }
    loop {
        let half = level - 1u;
        let bits = (voxel >> vec3u(half)) & vec3u(1u);
        let child = 2u * select(voxel.z & 7u, bits.x << 2u | bits.y << 1u | bits.z, level > 3u);
        let at = v.places.x + word;
        let header = voxel_word(at);
        let state = (header >> child) & 3u;
        if (state < 2u) {
            return vec2u(0u - state);
        }
        // The pointers of mixed children stand in their order.
        word = voxel_word(at + 1u + countOneBits(header & 0xaaaau & ((1u << child) - 1u)));
        if (level == 3u) {
            let slab = v.places.y + 2u * word;
            return vec2u(voxel_word(slab), voxel_word(slab + 1u));
        }
        level = half;
    }
    // Not reached; some compilers ask for it.
    return vec2u(0u);
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

// Lit taps among the texels low…high, which lie in one block.
fn voxel_block(v: VoxelParams, r: VoxelReceiver, low: vec2i, high: vec2i) -> u32 {
    let count = u32((high.x - low.x + 1) * (high.y - low.y + 1));
    // Texels beside the grid are lit.
    let inside_low = max(low, vec2i(0));
    let inside_high = min(high, v.grid.size.xy - 1);
    let to_center = (low + high + 1) * (FIXED_ONE / 2) - r.p_fixed.xy;
    let along = r.gradient * to_center - abs(r.gradient) * (high - low) * (FIXED_ONE / 2);
    let layer = (r.p_fixed.z + ((along.x + along.y) >> GRADIENT_BITS)) >> FIXED_BITS;
    if (any(inside_low > inside_high) || layer < 0) {
        return count;
    }
    let mask = voxel_rectangle(inside_low, inside_high);
    let slab = voxel_slab(v, vec3u(vec3i(inside_low, min(layer, v.grid.size.z - 1))));
    let bits = countOneBits(slab & mask);
    let taps = countOneBits(mask);
    return count - (taps.x + taps.y) + bits.x + bits.y;
}

// Lit taps of K².
fn voxel_lit_taps(v: VoxelParams, r: VoxelReceiver) -> u32 {
    let reach = i32(v.places.z >> 1u);
    let texel = r.p_fixed.xy >> vec2u(FIXED_BITS);
    let low = texel - reach;
    let high = texel + reach;
    var lit = 0u;
    for (var y = low.y; y <= high.y; y = (y | 7) + 1) {
        for (var x = low.x; x <= high.x; x = (x | 7) + 1) {
            lit += voxel_block(v, r, vec2i(x, y), min(vec2i(x, y) | vec2i(7), high));
        }
    }
    return lit;
}

fn voxel_factor(v: VoxelParams, s: Surface) -> f32 {
    return f32(voxel_lit_taps(v, voxel_receiver(v, s))) / f32(v.places.z * v.places.z);
}
