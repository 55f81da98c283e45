// Look-up in a multiresolution hierarchy; the twin of adumbra::hierarchy, whose text has the words, and the same to the last tap.
// Source: Scandolo, Bauszat, Eisemann, Merged Multiresolution Hierarchies for Shadow Map Compression, 2016.
// Words come through `fn voxel_word(index: u32) -> u32` of an access/ file: top, wide entries and code one behind the other, the latter
// two from `places.x` and `places.y` on. Receivers, masks and layers are those of core/voxel.wgsl.

// Columns and where they switch: all at `base`, or as a shape says that stands at half-word `at`.
struct HierarchyPlace {
    // HIERARCHY_UNIFORM: no shape.
    at: u32,
    base: u32,
}

fn hierarchy_half(v: VoxelParams, at: u32) -> u32 {
    return extractBits(voxel_word(v.places.y + (at >> 1u)), 16u * (at & 1u), 16u);
}

fn hierarchy_two_halves(v: VoxelParams, at: u32) -> u32 {
    let word = voxel_word(v.places.y + (at >> 1u));
    if ((at & 1u) == 0u) {
        return word;
    }
    return (word >> 16u) | (voxel_word(v.places.y + (at >> 1u) + 1u) << 16u);
}

// A half-word in two's complement.
fn hierarchy_delta(v: VoxelParams, at: u32) -> u32 {
    return u32(extractBits(i32(hierarchy_half(v, at)), 0u, 16u));
}

// The address that a near pointer at `field` of a shape means.
fn hierarchy_near(v: VoxelParams, shape: u32, field: u32) -> u32 {
    let half = hierarchy_half(v, field);
    return select(half, shape - (half & 0x7fffu), (half & 0x8000u) != 0u);
}

// From a node to one of its sixteen children.
fn hierarchy_child(v: VoxelParams, p: HierarchyPlace, child: u32) -> HierarchyPlace {
    let sizes = hierarchy_two_halves(v, p.at);
    let kind = extractBits(hierarchy_half(v, p.at + 2u), child, 1u);
    let below = (1u << child) - 1u;
    let field = p.at + 3u + countOneBits(sizes & below) + 2u * countOneBits((sizes >> 16u) & below);
    switch 4u * extractBits(sizes, 16u + child, 1u) + 2u * extractBits(sizes, child, 1u) + kind {
        case 0u: {
            return HierarchyPlace(HIERARCHY_UNIFORM, p.base);
        }
        case 1u: {
            return HierarchyPlace(HIERARCHY_UNIFORM, HIERARCHY_NEVER);
        }
        case 2u: {
            return HierarchyPlace(hierarchy_near(v, p.at, field), p.base);
        }
        case 3u: {
            return HierarchyPlace(HIERARCHY_UNIFORM, p.base + hierarchy_delta(v, field));
        }
        case 4u: {
            return HierarchyPlace(hierarchy_two_halves(v, field), p.base);
        }
        case 5u: {
            return HierarchyPlace(hierarchy_near(v, p.at, field + 1u), p.base + hierarchy_delta(v, field));
        }
        case 6u: {
            return HierarchyPlace(hierarchy_two_halves(v, field + 1u), p.base + hierarchy_delta(v, field));
        }
        default: {
            let entry = v.places.x + 2u * hierarchy_two_halves(v, field);
            return HierarchyPlace(voxel_word(entry + 1u), p.base + voxel_word(entry));
        }
    }
}

// The leaf or the uniform block that holds a column of the grid.
fn hierarchy_place(v: VoxelParams, column: vec2u) -> HierarchyPlace {
    let root = column >> vec2u(v.top_dims.w);
    let entry = 2u * (root.y * v.top_dims.x + root.x);
    var p = HierarchyPlace(voxel_word(entry), voxel_word(entry + 1u));
    for (var level = v.top_dims.w; level > 3u && p.at != HIERARCHY_UNIFORM; level -= 2u) {
        let bits = (column >> vec2u(level - 2u)) & vec2u(3u);
        p = hierarchy_child(v, p, bits.y << 2u | bits.x);
    }
    return p;
}

// A leaf, read up to its planes.
struct HierarchyLeaf {
    base: u32,
    // The last rank, and how many depths are differences.
    last: u32,
    differences: u32,
    // They take 8 << width bits from this half-word on.
    width: u32,
    first: u32,
    // Half-word at which the planes begin, and how many there are.
    planes: u32,
    plane_count: u32,
    // Quarters of a voxel a column.
    slant: vec2i,
}

fn hierarchy_leaf(v: VoxelParams, p: HierarchyPlace) -> HierarchyLeaf {
    let head = hierarchy_half(v, p.at);
    var leaf: HierarchyLeaf;
    leaf.base = p.base;
    leaf.last = head & 63u;
    leaf.differences = leaf.last - extractBits(head, 6u, 1u);
    leaf.width = extractBits(head, 7u, 2u);
    leaf.first = p.at + 1u;
    if (extractBits(head, 9u, 1u) == 1u) {
        let gradient = i32(hierarchy_half(v, p.at + 1u));
        leaf.slant = vec2i(extractBits(gradient, 0u, 8u), extractBits(gradient, 8u, 8u));
        leaf.first += 1u;
    }
    leaf.planes = leaf.first + (((leaf.differences << leaf.width) + 1u) >> 1u);
    leaf.plane_count = 32u - countLeadingZeros(leaf.last);
    return leaf;
}

fn hierarchy_difference(v: VoxelParams, leaf: HierarchyLeaf, index: u32) -> u32 {
    if (leaf.width == 0u) {
        return extractBits(hierarchy_half(v, leaf.first + (index >> 1u)), 8u * (index & 1u), 8u);
    }
    if (leaf.width == 1u) {
        return hierarchy_half(v, leaf.first + index);
    }
    return hierarchy_two_halves(v, leaf.first + 2u * index);
}

// A sum of depths, which ends at HIERARCHY_NEVER.
fn hierarchy_deeper(depth: u32, difference: u32) -> u32 {
    return depth + min(difference, ~depth);
}

fn hierarchy_plane(v: VoxelParams, leaf: HierarchyLeaf, plane: u32) -> vec2u {
    let at = leaf.planes + 4u * plane;
    return vec2u(hierarchy_two_halves(v, at), hierarchy_two_halves(v, at + 2u));
}

// How much nearer than the deepest corner of its plane a column of a leaf switches.
fn hierarchy_rise(slant: vec2i, column: vec2i) -> u32 {
    let from_deepest = select(column, 7 - column, slant > vec2i(0));
    let quarters = abs(slant) * from_deepest;
    return u32(quarters.x + quarters.y + 3) >> 2u;
}

// Columns that rise by less than this, which is at least 1 and at most the largest rise: in every row those from the deepest on.
fn hierarchy_below(slant: vec2i, rise: u32) -> vec2u {
    let steep = abs(slant);
    let most = i32(4u * rise - 4u);
    // Quotients of numbers up to 7 · steep.x by one reciprocal, exact: 2^20 / steep.x is at least 1 / 128 from the nearest whole number where it is
    // none itself, and farther than a division of floats errs. Where it is a whole number, it or the next one results. Both give the right
    // floors, as adumbra::hierarchy proves for the next one.
    let inverse = i32(1048576.0 / f32(max(steep.x, 1))) + 1;
    var bits = vec2u(0u);
    for (var row = 0; row < 8; row++) {
        let left = most - steep.y * select(row, 7 - row, slant.y > 0);
        var columns = u32(((min(left, 7 * steep.x) * inverse) >> 20u) + 1);
        columns = select(select(columns, 8u, steep.x == 0), 0u, left < 0);
        let place = 8u * (u32(row) & 3u) + select(0u, 8u - columns, slant.x > 0);
        bits[row >> 2u] |= insertBits(0u, 0xffu, place, columns);
    }
    return bits;
}

// Depth at which a column of the grid switches; HIERARCHY_NEVER where all of it is lit.
fn hierarchy_value(v: VoxelParams, column: vec2u) -> u32 {
    let p = hierarchy_place(v, column);
    if (p.at == HIERARCHY_UNIFORM) {
        return p.base;
    }
    let leaf = hierarchy_leaf(v, p);
    let within = column & vec2u(7u);
    var rank = 0u;
    for (var plane = 0u; plane < leaf.plane_count; plane++) {
        let half = hierarchy_half(v, leaf.planes + 4u * plane + (within.y >> 1u));
        rank |= extractBits(half, (within.y & 1u) << 3u | within.x, 1u) << plane;
    }
    if (rank > leaf.differences) {
        return HIERARCHY_NEVER;
    }
    var depth = p.base;
    for (var d = 0u; d < rank; d++) {
        depth = hierarchy_deeper(depth, hierarchy_difference(v, leaf, d));
    }
    return depth - min(hierarchy_rise(leaf.slant, vec2i(within)), depth);
}

// Columns of one rank.
fn hierarchy_of_rank(v: VoxelParams, leaf: HierarchyLeaf, rank: u32) -> vec2u {
    var bits = vec2u(0xffffffffu);
    for (var p = 0u; p < leaf.plane_count; p++) {
        let plane = hierarchy_plane(v, leaf, p);
        bits &= select(~plane, plane, extractBits(rank, p, 1u) == 1u);
    }
    return bits;
}

// Columns of at least this rank: all compared at once, the highest bit first.
fn hierarchy_from_rank(v: VoxelParams, leaf: HierarchyLeaf, rank: u32) -> vec2u {
    if (rank > leaf.last) {
        return vec2u(0u);
    }
    var more = vec2u(0u);
    var equal = vec2u(0xffffffffu);
    for (var i = leaf.plane_count; i > 0u; i--) {
        let plane = hierarchy_plane(v, leaf, i - 1u);
        if (extractBits(rank, i - 1u, 1u) == 0u) {
            more |= equal & plane;
            equal &= ~plane;
        } else {
            equal &= plane;
        }
    }
    return more | equal;
}

// The slab of 8 × 8 columns of a leaf at depth k: bit y·8 + x, rows 0 to 3 in x, 1 = lit.
fn hierarchy_slab(v: VoxelParams, leaf: HierarchyLeaf, k: u32) -> vec2u {
    let steep = abs(leaf.slant);
    let largest_rise = u32(7 * (steep.x + steep.y) + 3) >> 2u;
    // Ranks that are dark all over, and the columns of others that are.
    var dark_ranks = 0u;
    var dark = vec2u(0u);
    var depth = leaf.base;
    for (var rank = 0u; rank <= leaf.differences; rank++) {
        if (rank > 0u) {
            depth = hierarchy_deeper(depth, hierarchy_difference(v, leaf, rank - 1u));
        }
        if (k + largest_rise < depth) {
            break;
        }
        if (depth <= k) {
            dark_ranks++;
        } else {
            dark |= hierarchy_of_rank(v, leaf, rank) & ~hierarchy_below(leaf.slant, depth - k);
        }
    }
    return ~dark & hierarchy_from_rank(v, leaf, dark_ranks);
}

// Lit taps among the columns low…high, which lie in one block.
fn hierarchy_block(v: VoxelParams, r: VoxelReceiver, low: vec2i, high: vec2i) -> u32 {
    let taps = voxel_taps(v, r, low, high);
    if (taps.farthest < 0) {
        return taps.beside;
    }
    let place = hierarchy_place(v, vec2u(taps.low));
    if (place.at == HIERARCHY_UNIFORM) {
        // A base behind the grid is never met.
        let last_lit = min(place.base, u32(v.grid.size.z)) - 1u;
        if (i32(last_lit) < taps.nearest) {
            return taps.beside;
        }
        return taps.beside + voxel_count(voxel_taps_to(r, taps, i32(last_lit)));
    }
    let leaf = hierarchy_leaf(v, place);
    // What was counted: all before the grid is lit.
    var counted = vec2u(0u);
    if (taps.nearest < 0) {
        counted = voxel_taps_to(r, taps, -1);
    }
    var lit = taps.beside + voxel_count(counted);
    for (var layer = max(taps.nearest, 0); layer <= taps.farthest; layer++) {
        let up_to = voxel_taps_to(r, taps, layer);
        let mask = up_to & ~counted;
        if (any(mask != vec2u(0u))) {
            lit += voxel_count(hierarchy_slab(v, leaf, u32(layer)) & mask);
        }
        counted = up_to;
    }
    return lit;
}

// Lit taps of K².
fn hierarchy_lit_taps(v: VoxelParams, r: VoxelReceiver) -> u32 {
    let reach = i32(v.places.z >> 1u);
    let low = (r.p_fixed.xy >> vec2u(FIXED_BITS)) - reach;
    let high = low + 2 * reach;
    var lit = 0u;
    for (var y = low.y; y <= high.y; y = (y | 7) + 1) {
        for (var x = low.x; x <= high.x; x = (x | 7) + 1) {
            lit += hierarchy_block(v, r, vec2i(x, y), min(vec2i(x, y) | vec2i(7), high));
        }
    }
    return lit;
}
