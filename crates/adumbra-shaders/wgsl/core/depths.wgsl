// Look-up in a light-aligned file in the layout "depths", a quadtree of switch depths. This is the
// counterpart of adumbra::layout::depths, which documents the words. Both give the same result for every tap.
// Source: Scandolo, Bauszat, Eisemann, Merged Multiresolution Hierarchies for Shadow Map Compression, 2016.
// Words are fetched by `fn adumbra_voxel_word(index: u32) -> u32` of an access/ file: top and code are
// concatenated, with the code from `code_offset` on: the common section, then pages. Receivers, masks and
// layers are defined in core/voxel.wgsl, leaves in core/depths_leaf.wgsl.
//
// A streamed file has words of several levels in one buffer: the table of a level begins at word `extra.x`,
// and blocks whose page is not resident have the address ADUMBRA_DEPTHS_ABSENT. spec/streaming.md describes
// it.

// A block of columns and their switch depths: all at `base`, or given by the shape at half-word `at`.
struct AdumbraDepthsNode {
    // ADUMBRA_DEPTHS_UNIFORM if there is no shape, ADUMBRA_DEPTHS_ABSENT if the page is not resident.
    at: u32,
    base: u32,
}

fn adumbra_depths_half(v: AdumbraVoxelParams, at: u32) -> u32 {
    return extractBits(adumbra_voxel_word(v.code_offset + (at >> 1u)), 16u * (at & 1u), 16u);
}

fn adumbra_depths_two_halves(v: AdumbraVoxelParams, at: u32) -> u32 {
    let word = adumbra_voxel_word(v.code_offset + (at >> 1u));
    if ((at & 1u) == 0u) {
        return word;
    }
    return (word >> 16u) | (adumbra_voxel_word(v.code_offset + (at >> 1u) + 1u) << 16u);
}

// Returns a half-word in two's complement, sign-extended.
fn adumbra_depths_delta(v: AdumbraVoxelParams, at: u32) -> u32 {
    return u32(extractBits(i32(adumbra_depths_half(v, at)), 0u, 16u));
}

// Returns the address encoded by the near pointer at half-word `field` of a shape: an address in the common
// section, or that of an earlier shape in the same page.
fn adumbra_depths_near(v: AdumbraVoxelParams, shape: u32, field: u32) -> u32 {
    let half = adumbra_depths_half(v, field);
    return select(half, shape - (half & 0x7fffu), (half & 0x8000u) != 0u);
}

// Returns the child of the far pointer at half-word `field` of a shape: a shape, or a switch if there is no
// distance.
fn adumbra_depths_far(v: AdumbraVoxelParams, node: AdumbraDepthsNode, field: u32) -> AdumbraDepthsNode {
    let far = adumbra_depths_two_halves(v, field + 1u);
    let delta = extractBits(i32(adumbra_depths_half(v, field) | (extractBits(far, 25u, 6u) << 16u)), 0u, 22u);
    let place = far & 0x1ffffffu;
    let at = select(place, node.at - place, (far & 0x80000000u) != 0u);
    // A pointer to the node itself means that there is no shape.
    return AdumbraDepthsNode(select(at, ADUMBRA_DEPTHS_UNIFORM, at == node.at), node.base + u32(delta));
}

// Returns the child of the short pointer at half-word `field` of a shape.
fn adumbra_depths_short(v: AdumbraVoxelParams, node: AdumbraDepthsNode, field: u32) -> AdumbraDepthsNode {
    let short = adumbra_depths_half(v, field);
    return AdumbraDepthsNode(node.at - (short & 0xffu), node.base + u32(extractBits(i32(short), 8u, 8u)));
}

// Returns one of a node's sixteen children.
fn adumbra_depths_child(v: AdumbraVoxelParams, node: AdumbraDepthsNode, child: u32) -> AdumbraDepthsNode {
    // Three half-words, one bit per child each, in two words.
    let word = v.code_offset + (node.at >> 1u);
    let first = adumbra_voxel_word(word);
    let second = adumbra_voxel_word(word + 1u);
    let is_odd = (node.at & 1u) == 1u;
    let sizes = select(first, (first >> 16u) | (second << 16u), is_odd);
    let kinds = select(second, second >> 16u, is_odd);
    let kind = extractBits(kinds, child, 1u);
    let below = (1u << child) - 1u;
    let low = sizes & 0xffffu;
    let high = sizes >> 16u;
    let shorts = high & ~(low | kinds);
    let field = node.at + 3u + countOneBits(low & below) + 2u * countOneBits(high & below) - countOneBits(shorts & below);
    switch 4u * extractBits(high, child, 1u) + 2u * extractBits(low, child, 1u) + kind {
        case 0u: {
            return AdumbraDepthsNode(ADUMBRA_DEPTHS_UNIFORM, node.base);
        }
        case 1u: {
            return AdumbraDepthsNode(ADUMBRA_DEPTHS_UNIFORM, ADUMBRA_DEPTHS_NEVER);
        }
        case 2u: {
            return AdumbraDepthsNode(adumbra_depths_near(v, node.at, field), node.base);
        }
        case 3u: {
            return AdumbraDepthsNode(ADUMBRA_DEPTHS_UNIFORM, node.base + adumbra_depths_delta(v, field));
        }
        case 4u: {
            return adumbra_depths_short(v, node, field);
        }
        case 5u: {
            return AdumbraDepthsNode(adumbra_depths_near(v, node.at, field + 1u), node.base + adumbra_depths_delta(v, field));
        }
        default: {
            return adumbra_depths_far(v, node, field);
        }
    }
}

// Returns the root that contains a column of the grid.
fn adumbra_depths_root(v: AdumbraVoxelParams, column: vec2u) -> AdumbraDepthsNode {
    let root = column >> vec2u(v.root_level);
    let entry = v.extra.x + 2u * (root.y * v.root_count.x + root.x);
    return AdumbraDepthsNode(adumbra_voxel_word(entry), adumbra_voxel_word(entry + 1u));
}

// Descends from a node of level `from_level` towards a column: to level `to_level`, or to a uniform block
// above it.
fn adumbra_depths_descend(v: AdumbraVoxelParams, from_node: AdumbraDepthsNode, column: vec2u, from_level: u32, to_level: u32) -> AdumbraDepthsNode {
    var node = from_node;
    for (var level = from_level; level > to_level && node.at < ADUMBRA_DEPTHS_ABSENT; level -= 2u) {
        let bits = (column >> vec2u(level - 2u)) & vec2u(3u);
        node = adumbra_depths_child(v, node, bits.y << 2u | bits.x);
    }
    return node;
}

// Returns the depth at which a column of the grid switches; ADUMBRA_DEPTHS_NEVER if the whole column is lit.
// The column's page must be resident.
fn adumbra_depths_value(v: AdumbraVoxelParams, column: vec2u) -> u32 {
    let node = adumbra_depths_descend(v, adumbra_depths_root(v, column), column, v.root_level, 3u);
    if (node.at == ADUMBRA_DEPTHS_UNIFORM) {
        return node.base;
    }
    return adumbra_depths_leaf_value(v, adumbra_depths_leaf(v, node), column & vec2u(7u));
}

// Counts the lit taps among the columns low…high, which are in one block; ADUMBRA_TAPS_ABSENT if its page is
// not resident. `node` has level `level` and contains the block.
fn adumbra_depths_block(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver, node: AdumbraDepthsNode, level: u32, low: vec2i, high: vec2i) -> u32 {
    let taps = adumbra_voxel_taps(v, r, low, high);
    if (taps.farthest < 0) {
        return taps.beside;
    }
    let column = vec2u(taps.low);
    var block = node;
    if (level == 0u) {
        block = adumbra_depths_descend(v, adumbra_depths_root(v, column), column, v.root_level, 3u);
    } else {
        block = adumbra_depths_descend(v, node, column, level, 3u);
    }
    if (block.at == ADUMBRA_DEPTHS_ABSENT) {
        return ADUMBRA_TAPS_ABSENT;
    }
    if (block.at != ADUMBRA_DEPTHS_UNIFORM) {
        return taps.beside + adumbra_depths_leaf_taps(v, r, adumbra_depths_leaf(v, block), taps);
    }
    // Clamp a base behind the grid to the grid's end.
    let last_lit = min(block.base, u32(v.grid.size.z)) - 1u;
    if (i32(last_lit) < taps.nearest) {
        return taps.beside;
    }
    return taps.beside + adumbra_voxel_count(adumbra_voxel_taps_to(r, taps, i32(last_lit)));
}

// Counts the lit taps of the K² filter; ADUMBRA_TAPS_ABSENT or more if a page under it is not resident.
fn adumbra_voxel_lit_taps(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver) -> u32 {
    let reach = i32(v.filter_width >> 1u);
    let low = (r.p_fixed.xy >> vec2u(ADUMBRA_FIXED_BITS)) - reach;
    let high = low + 2 * reach;
    // The lowest node that contains all columns is found once. `level` is 0 if no single root contains them.
    let from_column = vec2u(clamp(low, vec2i(0), v.grid.size.xy - 1));
    let to_column = vec2u(clamp(high, vec2i(0), v.grid.size.xy - 1));
    let differs = (from_column.x ^ to_column.x) | (from_column.y ^ to_column.y);
    let shared_level = max(32u - countLeadingZeros(differs), 3u);
    var node = AdumbraDepthsNode(0u, 0u);
    var level = 0u;
    if (shared_level <= v.root_level) {
        // Levels are odd.
        level = shared_level | 1u;
        node = adumbra_depths_descend(v, adumbra_depths_root(v, from_column), from_column, v.root_level, level);
    }
    var lit = 0u;
    for (var y = low.y; y <= high.y; y = (y | 7) + 1) {
        for (var x = low.x; x <= high.x; x = (x | 7) + 1) {
            lit += adumbra_depths_block(v, r, node, level, vec2i(x, y), min(vec2i(x, y) | vec2i(7), high));
        }
    }
    return lit;
}
