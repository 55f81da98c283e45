// Down the levels of a hybrid-resolution shadow map: level 0 holds the finest texels, level `merges` is where a look-up begins.
// Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, algorithm 2. Here a comparison is with the receiver's plane
// at the finest texel's centre, as in core/pcf.wgsl: where nothing has merged, answers are those of the shadow map.
// An access file gives hybrid_root, hybrid_child and hybrid_finest; hybrid_plane or hybrid_mean gives hybrid_leaf.

struct HybridTexel {
    // Depth at the centre of the finest texel.
    depth: f32,
    // Where it was found.
    level: u32,
}

fn hybrid_is_index(word: u32) -> bool {
    return (word & HYBRID_INDEX) != 0u;
}

// Middle of a texel of a level, in finest texels.
fn hybrid_centre(texel: vec2u, level: u32) -> vec2f {
    return (vec2f(texel) + 0.5) * f32(1u << level);
}

// What the map holds at a finest texel, which must lie within it.
fn hybrid_texel(params: HybridParams, texel: vec2u) -> HybridTexel {
    var level = params.counts.y;
    var word = hybrid_root(texel >> vec2u(level), params.counts.x >> level);
    while (hybrid_is_index(word)) {
        level--;
        if (level == 0u) {
            return HybridTexel(hybrid_finest(word, texel, params.counts.w == 1u), 0u);
        }
        word = hybrid_child(word, texel >> vec2u(level));
    }
    let leaf = hybrid_leaf(word, params.slope.x);
    let offset = vec2f(texel) + 0.5 - hybrid_centre(texel >> vec2u(level), level);
    return HybridTexel(leaf.x + dot(leaf.yz, offset), level);
}

// The finest texel that the receiver lies in.
fn hybrid_receiver_texel(params: HybridParams, r: MapReceiver) -> vec2u {
    return vec2u(clamp(vec2i(floor(r.p_texels)), vec2i(0), vec2i(i32(params.counts.x) - 1)));
}

fn hybrid_nearest(params: HybridParams, r: MapReceiver) -> f32 {
    let texel = hybrid_receiver_texel(params, r);
    let found = hybrid_texel(params, texel);
    return select(0.0, 1.0, map_plane_depth(r, vec2f(texel) + 0.5) <= found.depth);
}
