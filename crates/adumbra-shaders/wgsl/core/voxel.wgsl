// Code shared by look-ups in light-aligned files: the receiver, the layer of its plane at a tap, and texel
// masks. This is the counterpart of adumbra::query. Source: Sintorn, Kämpe, Olsson, Assarsson, Compact
// Precomputed Voxelized Shadows, 2014; spec/adumbra-file.md. Words are fetched by
// `fn adumbra_voxel_word(index: u32) -> u32` of an access/ file.

struct AdumbraVoxelReceiver {
    p_fixed: vec3i,
    gradient: vec2i,
}

// Returns the biased receiver, with the slope of its plane.
fn adumbra_voxel_receiver(v: AdumbraVoxelParams, s: AdumbraSurface) -> AdumbraVoxelReceiver {
    let n = adumbra_grid_normal(v.grid, s.normal);
    let tangent = length(n.xy);
    // |n.z| is |n·l|, times the length of a voxel along the light in voxels.
    let n_dot_l = max(abs(n.z), tangent / ADUMBRA_MAX_PLANE_SLOPE);
    var gradient = vec2f(0.0);
    var slope = 0.0;
    if (n_dot_l > 0.0) {
        gradient = n.xy / select(n_dot_l, -n_dot_l, n.z > 0.0);
        slope = min(tangent / n_dot_l, ADUMBRA_MAX_SLOPE);
    }
    let off_surface = adumbra_grid_direction(v.grid, s.normal) * v.bias.normal_offset_texels;
    let lift = off_surface - vec3f(0.0, 0.0, adumbra_bias_along_light(v.bias, slope));
    var r: AdumbraVoxelReceiver;
    r.p_fixed = adumbra_grid_fixed(v.grid, adumbra_grid_position(v.grid, s.p_relative), lift);
    let rounded = vec2i(floor(gradient * f32(ADUMBRA_GRADIENT_ONE) + 0.5));
    r.gradient = clamp(rounded, vec2i(-ADUMBRA_MAX_GRADIENT), vec2i(ADUMBRA_MAX_GRADIENT));
    return r;
}

// Returns the mask of the texels low…high, which are in one block.
fn adumbra_voxel_rectangle(low: vec2i, high: vec2i) -> vec2u {
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

fn adumbra_voxel_count(bits: vec2u) -> u32 {
    return countOneBits(bits.x) + countOneBits(bits.y);
}

// The taps of one block that are over the grid, and the number of those outside it, where everything is lit.
struct AdumbraVoxelTaps {
    low: vec2i,
    high: vec2i,
    // Range of layers that the taps read; -1 stands for everything in front of the grid.
    nearest: i32,
    farthest: i32,
    // Whether no tap is in front of or behind the grid, where layers are not those of the plane.
    is_within: bool,
    beside: u32,
}

// Returns the depth of the receiver's plane at the centre of a tap, fixed point, rounded down.
fn adumbra_voxel_plane(r: AdumbraVoxelReceiver, tap: vec2i) -> i32 {
    let along = r.gradient * (tap * ADUMBRA_FIXED_ONE + ADUMBRA_FIXED_ONE / 2 - r.p_fixed.xy);
    return r.p_fixed.z + ((along.x + along.y) >> ADUMBRA_GRADIENT_BITS);
}

// Returns the layer of the receiver's plane at the centre of a tap.
fn adumbra_voxel_layer(r: AdumbraVoxelReceiver, tap: vec2i) -> i32 {
    return adumbra_voxel_plane(r, tap) >> ADUMBRA_FIXED_BITS;
}

// Returns the voxel that an unfiltered look-up of the receiver reads; z is negative beside or in front of the
// grid, where nothing is looked up.
fn adumbra_voxel_of(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver) -> vec3i {
    let texel = r.p_fixed.xy >> vec2u(ADUMBRA_FIXED_BITS);
    let layer = adumbra_voxel_layer(r, texel);
    if (any(texel < vec2i(0)) || any(texel >= v.grid.size.xy) || layer < 0) {
        return vec3i(texel, -1);
    }
    return vec3i(texel, min(layer, v.grid.size.z - 1));
}

// Returns the taps low…high, which are in one block.
fn adumbra_voxel_taps(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, low: vec2i, high: vec2i) -> AdumbraVoxelTaps {
    let size = high - low + 1;
    let count = u32(size.x * size.y);
    var taps: AdumbraVoxelTaps;
    taps.low = max(low, vec2i(0));
    taps.high = min(high, v.grid.size.xy - 1);
    if (any(taps.low > taps.high)) {
        return AdumbraVoxelTaps(taps.low, taps.high, -1, -1, false, count);
    }
    let rises = r.gradient >= vec2i(0);
    let last = v.grid.size.z - 1;
    let nearest = adumbra_voxel_layer(r, select(taps.high, taps.low, rises));
    let farthest = adumbra_voxel_layer(r, select(taps.low, taps.high, rises));
    taps.nearest = clamp(nearest, -1, last);
    taps.farthest = clamp(farthest, -1, last);
    taps.is_within = nearest >= 0 && farthest <= last;
    if (taps.farthest < 0) {
        taps.beside = count;
        return taps;
    }
    let inside = taps.high - taps.low + 1;
    taps.beside = count - u32(inside.x * inside.y);
    return taps;
}

// Returns how many of up to eight steps, each rising by `steep`, begin at a rise of at most `left`. Quotients
// of these numbers are never so close to an integer that the added half or the error of the division matters.
fn adumbra_voxel_steps(left: i32, steep: i32) -> i32 {
    let quotient = i32((f32(clamp(left, 0, 7 * steep)) + 0.5) / f32(max(steep, 1)));
    return select(select(quotient + 1, 8, steep == 0), 0, left < 0);
}

// Returns the taps of a block whose layer is `layer` or in front of it: bit y·8 + x, rows 0 to 3 in x.
// `layer` is one of the taps' layers, or -1.
fn adumbra_voxel_taps_to(r: AdumbraVoxelReceiver, taps: AdumbraVoxelTaps, layer: i32) -> vec2u {
    if (layer >= taps.farthest) {
        return adumbra_voxel_rectangle(taps.low, taps.high);
    }
    let rises = r.gradient >= vec2i(0);
    let steep = abs(r.gradient);
    // The rise that the plane may still make from the point on, minus its rise at the nearest tap.
    let limit = ((((layer + 1) << ADUMBRA_FIXED_BITS) - r.p_fixed.z) << ADUMBRA_GRADIENT_BITS) - 1;
    let nearest = select(taps.high, taps.low, rises);
    let along = r.gradient * (nearest * ADUMBRA_FIXED_ONE + ADUMBRA_FIXED_ONE / 2 - r.p_fixed.xy);
    var left = (limit - along.x - along.y) >> ADUMBRA_FIXED_BITS;
    let size = taps.high - taps.low + 1;
    if (steep.x == 0) {
        // Each row has constant depth.
        let rows = min(adumbra_voxel_steps(left, steep.y), size.y);
        if (rows == 0) {
            return vec2u(0u);
        }
        let low_y = select(taps.high.y + 1 - rows, taps.low.y, rises.y);
        return adumbra_voxel_rectangle(vec2i(taps.low.x, low_y), vec2i(taps.high.x, low_y + rows - 1));
    }
    var bits = vec2u(0u);
    // Goes from the nearest row on, while rows have taps.
    for (var row = 0; row < size.y && left >= 0; row++) {
        let y = select(taps.high.y - row, taps.low.y + row, rises.y) & 7;
        let columns = min(adumbra_voxel_steps(left, steep.x), size.x);
        let from_x = select(taps.high.x + 1 - columns, taps.low.x, rises.x) & 7;
        let few = ((1u << u32(columns)) - 1u) << u32(8 * (y & 3) + from_x);
        bits |= select(vec2u(0u, few), vec2u(few, 0u), y < 4);
        left -= steep.y;
    }
    return bits;
}

// Returns the visibility, filtered over K × K texels; -1 if a page under the filter is not resident.
// core/depths.wgsl defines adumbra_voxel_lit_taps.
fn adumbra_voxel_factor(v: AdumbraVoxelParams, s: AdumbraSurface) -> f32 {
    let lit = adumbra_voxel_lit_taps(v, adumbra_voxel_receiver(v, s));
    return select(f32(lit) / f32(v.filter_width * v.filter_width), -1.0, lit >= ADUMBRA_TAPS_ABSENT);
}
