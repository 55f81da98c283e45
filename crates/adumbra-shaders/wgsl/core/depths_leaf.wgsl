// Leaves of a light-aligned file in the layout "depths": 8 × 8 columns, their ranks in bit planes, the depth
// of each rank, and an optional slant. This is the counterpart of adumbra::layout::depths, which documents
// the words. core/depths.wgsl must precede this file.

// A leaf, decoded.
struct AdumbraDepthsLeaf {
    // The depth of the first rank, or its deepest corner.
    base: u32,
    // The last rank, and the number of depths that are stored as differences.
    last: u32,
    differences: u32,
    // The differences take 8 << width bits each, from half-word `first` on.
    width: u32,
    first: u32,
    // Number of bit planes, and the planes.
    plane_count: u32,
    planes: array<vec2u, 6>,
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
    leaf.plane_count = 32u - countLeadingZeros(leaf.last);
    let planes = leaf.first + (((leaf.differences << leaf.width) + 1u) >> 1u);
    for (var p = 0u; p < leaf.plane_count; p++) {
        leaf.planes[p] = adumbra_depths_plane(v, planes + 4u * p);
    }
    return leaf;
}

// Returns the four half-words at `at`.
fn adumbra_depths_plane(v: AdumbraVoxelParams, at: u32) -> vec2u {
    let word = v.code_offset + (at >> 1u);
    let plane = vec2u(adumbra_voxel_word(word), adumbra_voxel_word(word + 1u));
    if ((at & 1u) == 0u) {
        return plane;
    }
    return (plane >> vec2u(16u)) | (vec2u(plane.y, adumbra_voxel_word(word + 2u)) << vec2u(16u));
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

// Returns how much nearer to the sun a column of a leaf switches than the deepest corner of the leaf's plane,
// in voxels.
fn adumbra_depths_rise(slant: vec2i, column: vec2i) -> u32 {
    return u32(adumbra_depths_quarters(slant, column) + 3) >> 2u;
}

// Returns the rise before it is rounded up, in quarters of a voxel.
fn adumbra_depths_quarters(slant: vec2i, column: vec2i) -> i32 {
    let from_deepest = select(column, 7 - column, slant > vec2i(0));
    let quarters = abs(slant) * from_deepest;
    return quarters.x + quarters.y;
}

fn adumbra_depths_largest_quarters(slant: vec2i) -> u32 {
    let steep = abs(slant);
    return u32(7 * (steep.x + steep.y));
}

// Returns the columns of one rank.
fn adumbra_depths_of_rank(leaf: AdumbraDepthsLeaf, rank: u32) -> vec2u {
    var bits = vec2u(0xffffffffu);
    for (var p = 0u; p < leaf.plane_count; p++) {
        bits &= select(~leaf.planes[p], leaf.planes[p], extractBits(rank, p, 1u) == 1u);
    }
    return bits;
}

// Returns the columns of at least this rank. All columns are compared at once, highest bit first.
fn adumbra_depths_from_rank(leaf: AdumbraDepthsLeaf, rank: u32) -> vec2u {
    if (rank > leaf.last) {
        return vec2u(0u);
    }
    var more = vec2u(0u);
    var equal = vec2u(0xffffffffu);
    for (var i = leaf.plane_count; i > 0u; i--) {
        let plane = leaf.planes[i - 1u];
        if (extractBits(rank, i - 1u, 1u) == 0u) {
            more |= equal & plane;
            equal &= ~plane;
        } else {
            equal &= plane;
        }
    }
    return more | equal;
}

// Returns the depth at which a column of the leaf switches.
fn adumbra_depths_leaf_value(v: AdumbraVoxelParams, leaf: AdumbraDepthsLeaf, column: vec2u) -> u32 {
    var rank = 0u;
    for (var p = 0u; p < leaf.plane_count; p++) {
        rank |= extractBits(leaf.planes[p][column.y >> 2u], (column.y & 3u) << 3u | column.x, 1u) << p;
    }
    if (rank > leaf.differences) {
        return ADUMBRA_DEPTHS_NEVER;
    }
    var depth = leaf.base;
    for (var d = 0u; d < rank; d++) {
        depth = adumbra_depths_deeper(depth, adumbra_depths_difference(v, leaf, d));
    }
    return depth - min(adumbra_depths_rise(leaf.slant, vec2i(column)), depth);
}

// Returns those of `columns`, all of one rank, that are lit where the receiver's plane crosses them. The
// rank's deepest corner switches at `depth`, which is within the layers of the taps.
fn adumbra_depths_lit_columns(r: AdumbraVoxelReceiver, taps: AdumbraVoxelTaps, slant: vec2i, depth: i32, columns: vec2u) -> vec2u {
    if (all(slant == vec2i(0))) {
        return columns & adumbra_voxel_taps_to(r, taps, depth - 1);
    }
    // The receiver's plane minus the rank's plane is linear, so its extremes are at corners. In 2^-12 voxels.
    let corners = array(taps.low, vec2i(taps.high.x, taps.low.y), vec2i(taps.low.x, taps.high.y), taps.high);
    var nearest = 0x7fffffff;
    var farthest = -0x7fffffff;
    for (var i = 0; i < 4; i++) {
        let quarters = adumbra_depths_quarters(slant, corners[i] & vec2i(7));
        let plane = adumbra_voxel_plane(r, corners[i]) + quarters * (ADUMBRA_FIXED_ONE / 4);
        nearest = min(nearest, plane);
        farthest = max(farthest, plane);
    }
    // The rise is rounded up and the layer down, and `plane` is rounded down by less than 1.
    if (farthest + ADUMBRA_FIXED_ONE * 3 / 4 < depth * ADUMBRA_FIXED_ONE) {
        return columns;
    }
    if (nearest >= depth * ADUMBRA_FIXED_ONE && taps.is_within) {
        return vec2u(0u);
    }
    var lit = vec2u(0u);
    for (var half = 0u; half < 2u; half++) {
        var left = columns[half];
        while (left != 0u) {
            let bit = firstTrailingBit(left);
            left &= left - 1u;
            let column = vec2i(i32(bit & 7u), i32(4u * half + (bit >> 3u)));
            let layer = min(adumbra_voxel_layer(r, (taps.low & vec2i(-8)) | column), taps.farthest);
            let is_lit = layer < 0 || layer + i32(adumbra_depths_rise(slant, column)) < depth;
            lit[half] |= u32(is_lit) << bit;
        }
    }
    return lit;
}

// Counts the lit taps in a leaf. Ranks entirely in front of or behind all taps are decided without a
// comparison per tap.
fn adumbra_depths_leaf_taps(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, leaf: AdumbraDepthsLeaf, taps: AdumbraVoxelTaps) -> u32 {
    let inside = adumbra_voxel_rectangle(taps.low, taps.high);
    let largest_rise = (adumbra_depths_largest_quarters(leaf.slant) + 3u) >> 2u;
    var lit = vec2u(0u);
    var depth = leaf.base;
    var rank = 0u;
    loop {
        if (rank > leaf.differences) {
            break;
        }
        if (rank > 0u) {
            depth = adumbra_depths_deeper(depth, adumbra_depths_difference(v, leaf, rank - 1u));
        }
        // This rank and all behind it switch behind every tap.
        if (u32(taps.farthest) + largest_rise < depth) {
            break;
        }
        if (i32(depth) > taps.nearest) {
            let columns = adumbra_depths_of_rank(leaf, rank) & inside;
            if (any(columns != vec2u(0u))) {
                lit |= adumbra_depths_lit_columns(r, taps, leaf.slant, i32(depth), columns);
            }
        }
        rank++;
    }
    return adumbra_voxel_count(lit | (adumbra_depths_from_rank(leaf, rank) & inside));
}
