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

// The layer of the receiver's plane at the centre of a tap.
fn voxel_layer(r: VoxelReceiver, tap: vec2i) -> i32 {
    let along = r.gradient * (tap * FIXED_ONE + FIXED_ONE / 2 - r.p_fixed.xy);
    return (r.p_fixed.z + ((along.x + along.y) >> GRADIENT_BITS)) >> FIXED_BITS;
}
