// Children of blocks that did not merge to their places in the map, and the coarsest level; one thread a block.

@group(1) @binding(0) var<storage, read_write> hybrid_words: array<u32>;

fn half_pair(left: f32, right: f32) -> u32 {
    return u32(left * 65535.0 + 0.5) | (u32(right * 65535.0 + 0.5) << 16u);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn hybrid_place(@builtin(global_invocation_id) id: vec3u) {
    let block = id.xy;
    if (any(block >= level.counts.zz)) {
        return;
    }
    var word = hybrid_levels[block_place(block)];
    if ((word & HYBRID_INDEX) != 0u && block_room(block, word) + level.places.z > level.room.x) {
        word = level.room.y;
        hybrid_levels[block_place(block)] = word;
    } else if ((word & HYBRID_INDEX) != 0u) {
        let place = block_room(block, word);
        if (level.counts.y > 1u) {
            let words = block_children(block);
            for (var i = 0u; i < 4u; i++) {
                hybrid_words[place + i] = words[i];
            }
        } else {
            let depths = block_depths(block);
            if (level.places.w == 1u) {
                hybrid_words[place] = half_pair(depths.x, depths.y);
                hybrid_words[place + 1u] = half_pair(depths.z, depths.w);
                // The next level begins at a multiple of four words.
                if (place % 4u == 0u && place + 2u == hybrid_counts[0]) {
                    hybrid_words[place + 2u] = 0u;
                    hybrid_words[place + 3u] = 0u;
                }
            } else {
                for (var i = 0u; i < 4u; i++) {
                    hybrid_words[place + i] = bitcast<u32>(depths[i]);
                }
            }
        }
        word = HYBRID_INDEX | place;
        hybrid_levels[block_place(block)] = word;
    }
    if (level.counts.y == level.counts.w) {
        hybrid_words[block.y * level.counts.z + block.x] = word;
    }
}
