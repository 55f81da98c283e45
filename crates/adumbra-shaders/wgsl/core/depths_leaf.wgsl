// Leaves of a light-aligned file in the layout "depths": 8 × 8 columns, their ranks in bit planes, the depth of each
// rank, and an optional slant. This is the counterpart of adumbra::layout::depths, which documents the words.
// core/depths.wgsl must precede this file.

// A leaf, decoded up to its bit planes.
struct AdumbraDepthsLeaf {
    base: u32,
    // The last rank, and the number of depths that are stored as differences.
    last: u32,
    differences: u32,
    // The differences take 8 << width bits each, from half-word `first` on.
    width: u32,
    first: u32,
    // First half-word of the bit planes, and their number.
    planes: u32,
    plane_count: u32,
    // Slant in quarters of a voxel per column.
    slant: vec2i,
}

fn adumbra_depths_leaf(v: AdumbraVoxelParams, node: AdumbraDepthsNode) -> AdumbraDepthsLeaf {
    let head = adumbra_depths_half(v, node.at);
    var leaf: AdumbraDepthsLeaf;
    leaf.base = node.base;
    leaf.last = head & 63u;
    leaf.differences = leaf.last - extractBits(head, 6u, 1u);
    leaf.width = extractBits(head, 7u, 2u);
    leaf.first = node.at + 1u;
    if (extractBits(head, 9u, 1u) == 1u) {
        let gradient = i32(adumbra_depths_half(v, node.at + 1u));
        leaf.slant = vec2i(extractBits(gradient, 0u, 8u), extractBits(gradient, 8u, 8u));
        leaf.first += 1u;
    }
    leaf.planes = leaf.first + (((leaf.differences << leaf.width) + 1u) >> 1u);
    leaf.plane_count = 32u - countLeadingZeros(leaf.last);
    return leaf;
}

fn adumbra_depths_difference(v: AdumbraVoxelParams, leaf: AdumbraDepthsLeaf, index: u32) -> u32 {
    if (leaf.width == 0u) {
        return extractBits(adumbra_depths_half(v, leaf.first + (index >> 1u)), 8u * (index & 1u), 8u);
    }
    if (leaf.width == 1u) {
        return adumbra_depths_half(v, leaf.first + index);
    }
    return adumbra_depths_two_halves(v, leaf.first + 2u * index);
}

// Returns the sum of two depths, clamped to ADUMBRA_DEPTHS_NEVER.
fn adumbra_depths_deeper(depth: u32, difference: u32) -> u32 {
    return depth + min(difference, ~depth);
}

fn adumbra_depths_plane(v: AdumbraVoxelParams, leaf: AdumbraDepthsLeaf, plane: u32) -> vec2u {
    let at = leaf.planes + 4u * plane;
    return vec2u(adumbra_depths_two_halves(v, at), adumbra_depths_two_halves(v, at + 2u));
}

// Returns how much nearer to the sun a column of a leaf switches than the deepest corner of the leaf's plane, in
// voxels.
fn adumbra_depths_rise(slant: vec2i, column: vec2i) -> u32 {
    let from_deepest = select(column, 7 - column, slant > vec2i(0));
    let quarters = abs(slant) * from_deepest;
    return u32(quarters.x + quarters.y + 3) >> 2u;
}

// Returns the columns that rise by less than `rise`, which is at least 1 and at most the largest rise. In every row
// these are the columns from the deepest one on.
fn adumbra_depths_below(slant: vec2i, rise: u32) -> vec2u {
    let steep = abs(slant);
    let limit = i32(4u * rise - 4u);
    // Exact quotients of numbers up to 7 · steep.x by means of one reciprocal. If 2^20 / steep.x is not an integer, it
    // is at least 1 / 128 from the nearest one, which is more than the error of a float division. If it is an integer,
    // `inverse` is that integer or the next larger one. Both give the correct floors; adumbra::layout::depths proves
    // this for the next larger one.
    let inverse = i32(1048576.0 / f32(max(steep.x, 1))) + 1;
    var bits = vec2u(0u);
    for (var row = 0; row < 8; row++) {
        let left = limit - steep.y * select(row, 7 - row, slant.y > 0);
        var columns = u32(((min(left, 7 * steep.x) * inverse) >> 20u) + 1);
        columns = select(select(columns, 8u, steep.x == 0), 0u, left < 0);
        let first_bit = 8u * (u32(row) & 3u) + select(0u, 8u - columns, slant.x > 0);
        bits[row >> 2u] |= insertBits(0u, 0xffu, first_bit, columns);
    }
    return bits;
}

// Returns the columns of one rank.
fn adumbra_depths_of_rank(v: AdumbraVoxelParams, leaf: AdumbraDepthsLeaf, rank: u32) -> vec2u {
    var bits = vec2u(0xffffffffu);
    for (var p = 0u; p < leaf.plane_count; p++) {
        let plane = adumbra_depths_plane(v, leaf, p);
        bits &= select(~plane, plane, extractBits(rank, p, 1u) == 1u);
    }
    return bits;
}

// Returns the columns of at least this rank. All columns are compared at once, highest bit first.
fn adumbra_depths_from_rank(v: AdumbraVoxelParams, leaf: AdumbraDepthsLeaf, rank: u32) -> vec2u {
    if (rank > leaf.last) {
        return vec2u(0u);
    }
    var more = vec2u(0u);
    var equal = vec2u(0xffffffffu);
    for (var i = leaf.plane_count; i > 0u; i--) {
        let plane = adumbra_depths_plane(v, leaf, i - 1u);
        if (extractBits(rank, i - 1u, 1u) == 0u) {
            more |= equal & plane;
            equal &= ~plane;
        } else {
            equal &= plane;
        }
    }
    return more | equal;
}

// Returns the leaf mask of 8 × 8 columns at depth k: bit y·8 + x, rows 0 to 3 in x, 1 = lit.
fn adumbra_depths_look_up(v: AdumbraVoxelParams, leaf: AdumbraDepthsLeaf, k: u32) -> vec2u {
    let steep = abs(leaf.slant);
    let largest_rise = u32(7 * (steep.x + steep.y) + 3) >> 2u;
    // Number of ranks that are entirely in shadow, and the shadowed columns of the other ranks.
    var shadowed_ranks = 0u;
    var dark = vec2u(0u);
    var depth = leaf.base;
    for (var rank = 0u; rank <= leaf.differences; rank++) {
        if (rank > 0u) {
            depth = adumbra_depths_deeper(depth, adumbra_depths_difference(v, leaf, rank - 1u));
        }
        if (k + largest_rise < depth) {
            break;
        }
        if (depth <= k) {
            shadowed_ranks++;
        } else {
            dark |= adumbra_depths_of_rank(v, leaf, rank) & ~adumbra_depths_below(leaf.slant, depth - k);
        }
    }
    return ~dark & adumbra_depths_from_rank(v, leaf, shadowed_ranks);
}
