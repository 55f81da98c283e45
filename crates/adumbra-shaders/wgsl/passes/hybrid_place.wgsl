// Writes the children of unmerged blocks to their positions in the map, and the coarsest level. One thread
// per block.

@group(1) @binding(0) var<storage, read_write> map_words: array<u32>;

fn half_pair(left: f32, right: f32) -> u32 {
    return u32(left * 65535.0 + 0.5) | (u32(right * 65535.0 + 0.5) << 16u);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn hybrid_place(@builtin(global_invocation_id) id: vec3u) {
    let block = id.xy;
    if (any(block >= vec2u(level.side_texels))) {
        return;
    }
    var word = hybrid_levels[block_offset(block)];
    if ((word & ADUMBRA_HYBRID_INDEX) != 0u && block_room(block, word) + level.split_size > level.room) {
        word = level.empty_word;
        hybrid_levels[block_offset(block)] = word;
    } else if ((word & ADUMBRA_HYBRID_INDEX) != 0u) {
        let offset = block_room(block, word);
        if (level.number > 1u) {
            let words = block_children(block);
            for (var i = 0u; i < 4u; i++) {
                map_words[offset + i] = words[i];
            }
        } else {
            let depths = block_depths(block);
            if (level.has_16_bit_depth == 1u) {
                map_words[offset] = half_pair(depths.x, depths.y);
                map_words[offset + 1u] = half_pair(depths.z, depths.w);
                // The next level begins at a multiple of four words.
                if (offset % 4u == 0u && offset + 2u == hybrid_counts[0]) {
                    map_words[offset + 2u] = 0u;
                    map_words[offset + 3u] = 0u;
                }
            } else {
                for (var i = 0u; i < 4u; i++) {
                    map_words[offset + i] = bitcast<u32>(depths[i]);
                }
            }
        }
        word = ADUMBRA_HYBRID_INDEX | offset;
        hybrid_levels[block_offset(block)] = word;
    }
    if (level.number == level.merges) {
        map_words[block.y * level.side_texels + block.x] = word;
    }
}
