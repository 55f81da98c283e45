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
    // |n·l| is |n.z|: the grid's z runs away from the sun.
    let n_dot_l = max(abs(n.z), tangent / MAX_PLANE_SLOPE);
    var gradient = vec2f(0.0);
    var slope = 0.0;
    if (n_dot_l > 0.0) {
        gradient = n.xy / select(n_dot_l, -n_dot_l, n.z > 0.0);
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

fn voxel_count(bits: vec2u) -> u32 {
    return countOneBits(bits.x) + countOneBits(bits.y);
}

// Taps of one block as far as they lie over the grid, and how many lie beside it, where all is lit.
struct VoxelTaps {
    low: vec2i,
    high: vec2i,
    // The layers that answer them; -1 for all before the grid.
    nearest: i32,
    farthest: i32,
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

// Taps low…high, which lie in one block.
fn voxel_taps(v: VoxelParams, r: VoxelReceiver, low: vec2i, high: vec2i) -> VoxelTaps {
    let size = high - low + 1;
    let count = u32(size.x * size.y);
    var taps: VoxelTaps;
    taps.low = max(low, vec2i(0));
    taps.high = min(high, v.grid.size.xy - 1);
    if (any(taps.low > taps.high)) {
        return VoxelTaps(taps.low, taps.high, -1, -1, count);
    }
    let rises = r.gradient >= vec2i(0);
    let last = v.grid.size.z - 1;
    taps.nearest = clamp(voxel_layer(r, select(taps.high, taps.low, rises)), -1, last);
    taps.farthest = clamp(voxel_layer(r, select(taps.low, taps.high, rises)), -1, last);
    if (v.places.w == 1u) {
        taps.farthest = taps.nearest;
    }
    if (taps.farthest < 0) {
        taps.beside = count;
        return taps;
    }
    let inside = taps.high - taps.low + 1;
    taps.beside = count - u32(inside.x * inside.y);
    return taps;
}

// How many of up to eight steps, each rising by `steep`, begin at a rise of at most `left`. No quotient of such numbers lies so near to a
// whole one that the half and a division's error would matter.
fn voxel_steps(left: i32, steep: i32) -> i32 {
    let quotient = i32((f32(clamp(left, 0, 7 * steep)) + 0.5) / f32(max(steep, 1)));
    return select(select(quotient + 1, 8, steep == 0), 0, left < 0);
}

// Those of a block's taps that a layer or one before it answers, bit y·8 + x, rows 0 to 3 in x. The layer is one of theirs, or -1.
fn voxel_taps_to(r: VoxelReceiver, taps: VoxelTaps, layer: i32) -> vec2u {
    if (layer >= taps.farthest) {
        return voxel_rectangle(taps.low, taps.high);
    }
    let rises = r.gradient >= vec2i(0);
    let steep = abs(r.gradient);
    // How far the plane may rise from the point on, and by how much it has risen at the nearest tap.
    let most = ((((layer + 1) << FIXED_BITS) - r.p_fixed.z) << GRADIENT_BITS) - 1;
    let nearest = select(taps.high, taps.low, rises);
    let along = r.gradient * (nearest * FIXED_ONE + FIXED_ONE / 2 - r.p_fixed.xy);
    var left = (most - along.x - along.y) >> FIXED_BITS;
    let size = taps.high - taps.low + 1;
    if (steep.x == 0) {
        // Rows are level.
        let rows = min(voxel_steps(left, steep.y), size.y);
        if (rows == 0) {
            return vec2u(0u);
        }
        let low_y = select(taps.high.y + 1 - rows, taps.low.y, rises.y);
        return voxel_rectangle(vec2i(taps.low.x, low_y), vec2i(taps.high.x, low_y + rows - 1));
    }
    var bits = vec2u(0u);
    // From the nearest row on, while any tap is left.
    for (var row = 0; row < size.y && left >= 0; row++) {
        let y = select(taps.high.y - row, taps.low.y + row, rises.y) & 7;
        let columns = min(voxel_steps(left, steep.x), size.x);
        let from_x = select(taps.high.x + 1 - columns, taps.low.x, rises.x) & 7;
        let few = ((1u << u32(columns)) - 1u) << u32(8 * (y & 3) + from_x);
        bits |= select(vec2u(0u, few), vec2u(few, 0u), y < 4);
        left -= steep.y;
    }
    return bits;
}
