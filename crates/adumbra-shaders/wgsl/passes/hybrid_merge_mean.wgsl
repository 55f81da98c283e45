// The test of the paper: four texels merge into their mean where none of them differs from it by more than e0 of its own depth.
// Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, equation 1, multiplied by D_n: so depth 0 is allowed. A light far away has no
// distance: D is counted from the near plane of the map.

fn block_merged(block: vec2u) -> u32 {
    var depths: vec4f;
    if (level.counts.y == 1u) {
        depths = block_depths(block);
    } else {
        let words = block_children(block);
        if (any((words & vec4u(HYBRID_INDEX)) != vec4u(0u))) {
            return HYBRID_INDEX;
        }
        depths = bitcast<vec4f>(words);
    }
    let mean = 0.25 * (((depths.x + depths.y) + depths.z) + depths.w);
    if (any(abs(vec4f(mean) - depths) > HYBRID_E0 * depths)) {
        return HYBRID_INDEX;
    }
    return bitcast<u32>(mean);
}
