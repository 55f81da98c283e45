// The march: visibility along the ray to one sun, from the depths of another sun's file. This is the
// counterpart of adumbra::query::march. Both give the same result for every start. core/depths.wgsl and
// core/depths_leaf.wgsl must precede this file. Source: spec/sun-path.md.

// The ray passes through a surface.
const ADUMBRA_MARCH_BLOCKED: u32 = 0u;
// The ray meets nothing.
const ADUMBRA_MARCH_CLEAR: u32 = 1u;
// From this value on, the ray meets nothing that the file shows, but has been in shadow, where something may
// be hidden. The excess over this value is the rise up to which the ray has been in shadow from its start on,
// in 2^-12 voxels.
const ADUMBRA_MARCH_UNKNOWN: u32 = 2u;

// Whether a ray that neither of two files can decide counts as blocked: it is hidden from both for this many
// voxels from its start; 0 = never.
fn adumbra_march_is_guessed_dark(first: u32, other: u32, dark_after_voxels: u32) -> bool {
    let hidden = (min(first, other) - ADUMBRA_MARCH_UNKNOWN) >> ADUMBRA_FIXED_BITS;
    return dark_after_voxels != 0u && hidden >= dark_after_voxels;
}

// Returns the distance along an axis after a rise: the slope has 16 fraction bits, the rise 12.
fn adumbra_march_aside(slope: i32, rise: u32) -> i32 {
    let steep = u32(abs(slope));
    let high = vec2u(steep >> 16u, rise >> 16u);
    let low = vec2u(steep & 0xffffu, rise & 0xffffu);
    let aside = ((high.x * high.y) << 16u) + high.x * low.y + low.x * high.y + ((low.x * low.y) >> 16u);
    return select(i32(aside), -i32(aside), slope < 0);
}

// Returns the rise to the border of the block of 2^level columns a side along one axis. Where that is farther
// than 16 texels, it is up to one 16th of a voxel less.
fn adumbra_march_rise_along(slope: i32, at: i32, level: u32) -> i32 {
    if (slope == 0) {
        return 0x7fffffff;
    }
    let side = 1 << (ADUMBRA_FIXED_BITS + level);
    let within = at & (side - 1);
    let left = u32(select(within + 1, side - within, slope > 0));
    let steep = u32(abs(slope));
    if (left < 0x10000u) {
        return i32(min((left << 16u) / steep, 0x7ffffffeu)) + 1;
    }
    return i32(min(((left << 8u) / steep) << 8u, 0x7fffffffu));
}

fn adumbra_march_rise(slope: vec2i, at: vec2i, level: u32) -> i32 {
    return min(adumbra_march_rise_along(slope.x, at.x, level), adumbra_march_rise_along(slope.y, at.y, level));
}

// Returns the start of a tap's ray: moved by the bias along the ray and the normal. `tap` is an offset in
// texels from the point, on the receiver's plane.
fn adumbra_march_start(v: AdumbraVoxelParams, slope: vec2i, s: AdumbraSurface, tap: vec2i) -> vec3i {
    let aside = vec2f(slope) / 65536.0;
    let n = adumbra_grid_normal(v.grid, s.normal);
    let tangent = length(n.xy);
    let along = max(abs(dot(n.xy, aside) - n.z), tangent / ADUMBRA_MAX_PLANE_SLOPE);
    var steep = 0.0;
    if (along > 0.0) {
        steep = min(tangent / along, ADUMBRA_MAX_SLOPE);
    }
    let rise = adumbra_bias_along_light(v.bias, steep);
    let off_surface = adumbra_grid_direction(v.grid, s.normal) * v.bias.normal_offset_texels;
    let lift = off_surface + vec3f(aside * rise, -rise);
    let start = adumbra_grid_fixed(v.grid, adumbra_grid_position(v.grid, s.p_relative), lift);
    let deeper = adumbra_voxel_receiver(v, s).gradient * tap;
    return start + vec3i(tap * ADUMBRA_FIXED_ONE, (deeper.x + deeper.y) * (ADUMBRA_FIXED_ONE / ADUMBRA_GRADIENT_ONE));
}

// Returns the smallest depth at which a column of a block switches, or a smaller depth.
fn adumbra_march_nearest(v: AdumbraVoxelParams, node: AdumbraDepthsNode) -> u32 {
    if (node.at >= ADUMBRA_DEPTHS_ABSENT || extractBits(adumbra_depths_half(v, node.at), 9u, 1u) == 0u) {
        return node.base;
    }
    let gradient = i32(adumbra_depths_half(v, node.at + 1u));
    let slant = vec2i(extractBits(gradient, 0u, 8u), extractBits(gradient, 8u, 8u));
    return node.base - min((adumbra_depths_largest_quarters(slant) + 3u) >> 2u, node.base);
}

// Follows a ray from its start. All pages must be resident.
fn adumbra_march(v: AdumbraVoxelParams, slope: vec2i, start: vec3i) -> u32 {
    let depth = min(start.z, v.grid.size.z * ADUMBRA_FIXED_ONE - 1);
    var has_been_dark = false;
    // The rise at which the ray first was in light, and at most its last rise.
    var lit_from = max(depth, 0);
    // The surface of the previous column, if the ray was in its shadow.
    var behind = ADUMBRA_DEPTHS_NEVER;
    // The block that the ray is in, and bounds of its depths. In a leaf, the ray passes several columns. The
    // leaf is read once, and only if the ray is not in front of all of its columns.
    var block = vec2u(0xffffffffu);
    var level = 0u;
    var node: AdumbraDepthsNode;
    // The node above the block, where the descent to the next block begins if the ray is still inside the
    // node.
    var parent: AdumbraDepthsNode;
    var parent_block = vec2u(0xffffffffu);
    var parent_level = 0u;
    var leaf: AdumbraDepthsLeaf;
    var has_leaf = false;
    var nearest = 0u;
    var farthest = 0u;
    var rise = 0;
    loop {
        let z = depth - rise;
        let at = start.xy + vec2i(adumbra_march_aside(slope.x, u32(rise)), adumbra_march_aside(slope.y, u32(rise)));
        let texel = at >> vec2u(ADUMBRA_FIXED_BITS);
        if (z < 0 || any(texel < vec2i(0)) || any(texel >= v.grid.size.xy)) {
            lit_from = min(lit_from, rise);
            break;
        }
        let column = vec2u(texel);
        let layer = u32(z >> ADUMBRA_FIXED_BITS);
        if (any((column >> vec2u(level)) != block)) {
            if (all((column >> vec2u(parent_level)) == parent_block)) {
                node = parent;
                level = parent_level;
            } else {
                node = adumbra_depths_root(v, column);
                level = v.root_level;
            }
            while (level > 3u && node.at < ADUMBRA_DEPTHS_ABSENT) {
                parent = node;
                parent_level = level;
                parent_block = column >> vec2u(level);
                level -= 2u;
                let bits = (column >> vec2u(level)) & vec2u(3u);
                node = adumbra_depths_child(v, node, bits.y << 2u | bits.x);
            }
            block = column >> vec2u(level);
            nearest = adumbra_march_nearest(v, node);
            has_leaf = false;
        }
        var value = nearest;
        var to_border = adumbra_march_rise(slope, at, level);
        if (layer >= nearest && node.at < ADUMBRA_DEPTHS_ABSENT) {
            if (!has_leaf) {
                leaf = adumbra_depths_leaf(v, node);
                farthest = node.base;
                for (var d = 0u; d < leaf.differences; d++) {
                    farthest = adumbra_depths_deeper(farthest, adumbra_depths_difference(v, leaf, d));
                }
                if (leaf.differences < leaf.last) {
                    farthest = ADUMBRA_DEPTHS_NEVER;
                }
                has_leaf = true;
            }
            if (adumbra_march_is_behind(z - to_border, farthest)) {
                // The ray passes all columns in shadow.
                value = farthest;
            } else {
                value = adumbra_depths_leaf_value(v, leaf, column & vec2u(7u));
                to_border = adumbra_march_rise(slope, at, 0u);
            }
        }
        if (layer < value) {
            if (behind != ADUMBRA_DEPTHS_NEVER && layer < behind + ADUMBRA_MARCH_EDGE_VOXELS) {
                return ADUMBRA_MARCH_BLOCKED;
            }
            behind = ADUMBRA_DEPTHS_NEVER;
            lit_from = min(lit_from, rise);
        } else {
            let left = z - to_border;
            if (left < 0 || u32(left >> ADUMBRA_FIXED_BITS) < value) {
                return ADUMBRA_MARCH_BLOCKED;
            }
            has_been_dark = true;
            behind = value;
        }
        if (to_border > z) {
            break;
        }
        rise += to_border;
    }
    return select(ADUMBRA_MARCH_CLEAR, ADUMBRA_MARCH_UNKNOWN + u32(lit_from), has_been_dark);
}

// Whether a depth is behind a surface, and far enough for the surface's edge not to matter.
fn adumbra_march_is_behind(z: i32, surface: u32) -> bool {
    return z >= 0 && surface != ADUMBRA_DEPTHS_NEVER && u32(z >> ADUMBRA_FIXED_BITS) >= surface + ADUMBRA_MARCH_EDGE_VOXELS;
}
