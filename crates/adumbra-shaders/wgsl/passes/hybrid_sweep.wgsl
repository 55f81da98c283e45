// Merging by the parallel line sweep: each thread owns a strip two texels wide and advances along it, one
// block per step. Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, algorithm 1.

@compute @workgroup_size(ADUMBRA_LIST_GROUP)
fn hybrid_sweep(@builtin(global_invocation_id) id: vec3u) {
    let y = id.x;
    let side = level.side_texels;
    if (y >= side) {
        return;
    }
    var rank = 0u;
    for (var x = 0u; x < side; x++) {
        let word = block_merged(vec2u(x, y));
        if (word == ADUMBRA_HYBRID_INDEX) {
            hybrid_levels[block_offset(vec2u(x, y))] = ADUMBRA_HYBRID_INDEX | rank;
            rank++;
        } else {
            hybrid_levels[block_offset(vec2u(x, y))] = word;
        }
        if ((x + 1u) % ADUMBRA_HYBRID_SECTION == 0u || x + 1u == side) {
            hybrid_counts[ADUMBRA_HYBRID_FIRST_SECTION + y * level_sections() + x / ADUMBRA_HYBRID_SECTION] = rank;
            rank = 0u;
        }
    }
}
