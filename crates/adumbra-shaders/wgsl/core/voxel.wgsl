// What look-ups in every layout of a light-aligned file share: the receiver, its plane's layer at a tap, masks of texels; the twin of
// adumbra::query. Source: Sintorn, Kämpe, Olsson, Assarsson, Compact Precomputed Voxelized Shadows, 2014; spec/adumbra-file.md.
// Words come through `fn voxel_word(index: u32) -> u32` of an access/ file.

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

// Taps of one block as far as they lie over the grid, and how many lie beside it, where all is lit.
struct VoxelTaps {
    low: vec2i,
    high: vec2i,
    // The one that they share; below 0 all are lit and counted as beside.
    layer: i32,
    beside: u32,
}

// The layer of the receiver's plane at the centre of a tap.
fn voxel_layer(r: VoxelReceiver, tap: vec2i) -> i32 {
    let along = r.gradient * (tap * FIXED_ONE + FIXED_ONE / 2 - r.p_fixed.xy);
    return (r.p_fixed.z + ((along.x + along.y) >> GRADIENT_BITS)) >> FIXED_BITS;
}

// The voxel that answers a receiver unfiltered; z below 0 beside the grid and before it, where nothing is looked up.
fn voxel_of(v: VoxelParams, r: VoxelReceiver) -> vec3i {
    let texel = r.p_fixed.xy >> vec2u(FIXED_BITS);
    let layer = voxel_layer(r, texel);
    if (any(texel < vec2i(0)) || any(texel >= v.grid.size.xy) || layer < 0) {
        return vec3i(texel, -1);
    }
    return vec3i(texel, min(layer, v.grid.size.z - 1));
}

// Taps low…high, which lie in one block. Their layer is that of the plane at their centre less half its slope times their extent, which is
// that at the tap where the plane is nearest to the sun.
fn voxel_taps(v: VoxelParams, r: VoxelReceiver, low: vec2i, high: vec2i) -> VoxelTaps {
    let size = high - low + 1;
    let count = u32(size.x * size.y);
    let inside_low = max(low, vec2i(0));
    let inside_high = min(high, v.grid.size.xy - 1);
    let layer = voxel_layer(r, select(high, low, r.gradient >= vec2i(0)));
    if (any(inside_low > inside_high) || layer < 0) {
        return VoxelTaps(inside_low, inside_high, -1, count);
    }
    let inside = inside_high - inside_low + 1;
    return VoxelTaps(inside_low, inside_high, min(layer, v.grid.size.z - 1), count - u32(inside.x * inside.y));
}
