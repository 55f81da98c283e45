// The merge test of the paper: four texels merge into their mean if none of them differs from it by more than
// e0 times its own depth. Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016,
// equation 1, multiplied by D_n to allow depth 0. A directional light has no distance, so D is measured from
// the near plane of the map.

fn block_merged(block: vec2u) -> u32 {
    var depths: vec4f;
    if (level.number == 1u) {
        depths = block_depths(block);
    } else {
        let words = block_children(block);
        if (any((words & vec4u(ADUMBRA_HYBRID_INDEX)) != vec4u(0u))) {
            return ADUMBRA_HYBRID_INDEX;
        }
        depths = bitcast<vec4f>(words);
    }
    let mean = 0.25 * (((depths.x + depths.y) + depths.z) + depths.w);
    if (any(abs(vec4f(mean) - depths) > ADUMBRA_HYBRID_E0 * depths)) {
        return ADUMBRA_HYBRID_INDEX;
    }
    return bitcast<u32>(mean);
}
