// Down the levels of a hybrid-resolution shadow map: level 0 holds the finest texels, level `merges` is where a look-up begins.
// Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, algorithm 2. Here a comparison is with the receiver's plane
// at the finest texel's centre, as in core/pcf.wgsl: where nothing has merged, answers are those of the shadow map.
// An access file gives hybrid_root, hybrid_child, hybrid_finest and hybrid_finest_block; hybrid_plane or hybrid_mean gives hybrid_leaf.

struct HybridShape {
    // Finest texels a side.
    start: u32,
    merges: u32,
    // Finest depths are 16 bits.
    halves: bool,
    // HybridParams.slope.x
    slope: i32,
}

struct HybridTexel {
    // Depth at the centre of the finest texel.
    depth: f32,
    // Where it was found.
    level: u32,
}

fn hybrid_shape(params: HybridParams) -> HybridShape {
    return HybridShape(params.counts.x, params.counts.y, params.counts.w == 1u, params.slope.x);
}

fn hybrid_is_index(word: u32) -> bool {
    return (word & HYBRID_INDEX) != 0u;
}

// Middle of a texel of a level, in finest texels.
fn hybrid_middle_of(texel: vec2u, level: u32) -> vec2f {
    return (vec2f(texel) + 0.5) * f32(1u << level);
}

// What the map holds at a finest texel, which must lie within it.
fn hybrid_texel(shape: HybridShape, texel: vec2u) -> HybridTexel {
    var level = shape.merges;
    var word = hybrid_root(texel >> vec2u(level), shape.start >> level);
    while (hybrid_is_index(word)) {
        level--;
        if (level == 0u) {
            return HybridTexel(hybrid_finest(word, texel, shape.halves), 0u);
        }
        word = hybrid_child(word, texel >> vec2u(level));
    }
    let leaf = hybrid_leaf(word, shape.slope);
    let offset = vec2f(texel) + 0.5 - hybrid_middle_of(texel >> vec2u(level), level);
    return HybridTexel(leaf.x + dot(leaf.yz, offset), level);
}

// The same for the four finest texels of a texel of level 1: left above, right above, left below, right below.
fn hybrid_block(shape: HybridShape, block: vec2u) -> vec4f {
    var level = shape.merges;
    var word = hybrid_root(block >> vec2u(level - 1u), shape.start >> level);
    while (hybrid_is_index(word)) {
        level--;
        if (level == 0u) {
            return hybrid_finest_block(word, block, shape.halves);
        }
        word = hybrid_child(word, block >> vec2u(level - 1u));
    }
    let leaf = hybrid_leaf(word, shape.slope);
    let corner = 2.0 * vec2f(block) + 1.0;
    let middle = leaf.x + dot(leaf.yz, corner - hybrid_middle_of(block >> vec2u(level - 1u), level));
    let right = 0.5 * leaf.y;
    let down = 0.5 * leaf.z;
    return vec4f(middle - right - down, middle + right - down, middle - right + down, middle + right + down);
}

// The finest texel that the receiver lies in.
fn hybrid_receiver_texel(shape: HybridShape, r: MapReceiver) -> vec2u {
    return vec2u(clamp(vec2i(floor(r.p_texels)), vec2i(0), vec2i(i32(shape.start) - 1)));
}

fn hybrid_nearest(shape: HybridShape, r: MapReceiver) -> f32 {
    let texel = hybrid_receiver_texel(shape, r);
    let found = hybrid_texel(shape, texel);
    return select(0.0, 1.0, map_plane_depth(r, vec2f(texel) + 0.5) <= found.depth);
}
