// Traversal of a hybrid-resolution shadow map. Level 0 holds the finest texels; a look-up begins at level
// `merges`. Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, algorithm 2. Here
// the stored depth is compared with the receiver's plane at the centre of the finest texel, as in
// core/pcf.wgsl. Where nothing has merged, results equal those of the shadow map. An access file defines
// adumbra_hybrid_root, adumbra_hybrid_child, adumbra_hybrid_finest and adumbra_hybrid_finest_block;
// core/hybrid_plane or hybrid_mean defines adumbra_hybrid_leaf.

struct AdumbraHybridShape {
    // Side length of the finest level, in texels.
    start: u32,
    merges: u32,
    // Whether the finest depths have 16 bits.
    halves: bool,
    // Slope of slope code 1, as in AdumbraHybridParams.
    slope: i32,
}

struct AdumbraHybridTexel {
    // Depth at the centre of the finest texel.
    depth: f32,
    // Level at which it was found.
    level: u32,
}

fn adumbra_hybrid_shape(params: AdumbraHybridParams) -> AdumbraHybridShape {
    return AdumbraHybridShape(params.start_texels, params.merges, params.has_16_bit_depth == 1u, params.slope_unit);
}

fn adumbra_hybrid_is_index(word: u32) -> bool {
    return (word & ADUMBRA_HYBRID_INDEX) != 0u;
}

// Centre of a texel of a level, in finest texels.
fn adumbra_hybrid_middle_of(texel: vec2u, level: u32) -> vec2f {
    return (vec2f(texel) + 0.5) * f32(1u << level);
}

// Returns the map's depth at a finest texel, which must be inside the map.
fn adumbra_hybrid_texel(shape: AdumbraHybridShape, texel: vec2u) -> AdumbraHybridTexel {
    var level = shape.merges;
    var word = adumbra_hybrid_root(texel >> vec2u(level), shape.start >> level);
    while (adumbra_hybrid_is_index(word)) {
        level--;
        if (level == 0u) {
            return AdumbraHybridTexel(adumbra_hybrid_finest(word, texel, shape.halves), 0u);
        }
        word = adumbra_hybrid_child(word, texel >> vec2u(level));
    }
    let leaf = adumbra_hybrid_leaf(word, shape.slope);
    let offset = vec2f(texel) + 0.5 - adumbra_hybrid_middle_of(texel >> vec2u(level), level);
    return AdumbraHybridTexel(leaf.x + dot(leaf.yz, offset), level);
}

// Returns the depths of the four finest texels of a texel of level 1: upper left, upper right, lower left,
// lower right.
fn adumbra_hybrid_block(shape: AdumbraHybridShape, block: vec2u) -> vec4f {
    var level = shape.merges;
    var word = adumbra_hybrid_root(block >> vec2u(level - 1u), shape.start >> level);
    while (adumbra_hybrid_is_index(word)) {
        level--;
        if (level == 0u) {
            return adumbra_hybrid_finest_block(word, block, shape.halves);
        }
        word = adumbra_hybrid_child(word, block >> vec2u(level - 1u));
    }
    let leaf = adumbra_hybrid_leaf(word, shape.slope);
    let corner = 2.0 * vec2f(block) + 1.0;
    let middle = leaf.x + dot(leaf.yz, corner - adumbra_hybrid_middle_of(block >> vec2u(level - 1u), level));
    let right = 0.5 * leaf.y;
    let down = 0.5 * leaf.z;
    return vec4f(middle - right - down, middle + right - down, middle - right + down, middle + right + down);
}

// Returns the finest texel that contains the receiver.
fn adumbra_hybrid_receiver_texel(shape: AdumbraHybridShape, r: AdumbraMapReceiver) -> vec2u {
    return vec2u(clamp(vec2i(floor(r.p_texels)), vec2i(0), vec2i(i32(shape.start) - 1)));
}

fn adumbra_hybrid_nearest(shape: AdumbraHybridShape, r: AdumbraMapReceiver) -> f32 {
    let texel = adumbra_hybrid_receiver_texel(shape, r);
    let found = adumbra_hybrid_texel(shape, texel);
    return select(0.0, 1.0, adumbra_map_plane_depth(r, vec2f(texel) + 0.5) <= found.depth);
}
