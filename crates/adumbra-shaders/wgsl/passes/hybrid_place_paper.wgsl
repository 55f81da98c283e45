// Writes the children of unmerged blocks to their positions in a map of the paper's layout, together with
// their links, the coarsest level, and the normal of each merged block. One thread per block. Texels are
// packed as in access/hybrid_paper.wgsl.

@group(1) @binding(0) var start_normals: texture_2d_array<f32>;
@group(1) @binding(1) var<storage, read_write> map_texels: array<vec4u>;
@group(1) @binding(2) var<storage, read_write> map_links: array<vec2u>;
// Packed normals of the blocks, at the same positions as the words in hybrid_levels; 0 if a block did not
// merge.
@group(1) @binding(3) var<storage, read_write> hybrid_normals: array<u32>;

fn start_normal(texel: vec2u) -> u32 {
    let bytes = adumbra_octahedral_bytes(textureLoad(start_normals, texel, 0, 0).xy);
    return bytes.x | (bytes.y << 8u);
}

// Returns the normals of a block's children: upper left, upper right, lower left, lower right.
fn block_normals(block: vec2u) -> vec4u {
    if (level.number == 1u) {
        let t = 2u * block;
        return vec4u(
            start_normal(t),
            start_normal(t + vec2u(1u, 0u)),
            start_normal(t + vec2u(0u, 1u)),
            start_normal(t + vec2u(1u, 1u)),
        );
    }
    let row = 2u * level.side_texels;
    let first = level.finer_offset + 2u * block.y * row + 2u * block.x;
    let below = first + row;
    return vec4u(hybrid_normals[first], hybrid_normals[first + 1u], hybrid_normals[below], hybrid_normals[below + 1u]);
}

// Returns the nearest of 65,536 depths, computed in integers, so that every machine finds the same one.
fn depth_unorm16(depth: f32) -> u32 {
    let steps = i32(depth * ADUMBRA_HYBRID_ONE);
    return u32((steps + ((i32(0.5 * ADUMBRA_HYBRID_ONE) - steps) >> 16u)) >> 8u);
}

fn paper_coordinate(texel: vec2u) -> u32 {
    return texel.x | (texel.y << 16u);
}

fn paper_texel(texel: vec2u, word: u32, normal: u32) -> vec4u {
    if ((word & ADUMBRA_HYBRID_INDEX) != 0u) {
        return vec4u(paper_coordinate(texel), 0u, word, 0u);
    }
    let depth = adumbra_hybrid_leaf(word, level.slope_unit).x;
    return vec4u(paper_coordinate(texel), word, 0u, (depth_unorm16(depth) << 16u) | normal);
}

fn paper_finest(texel: vec2u, depth: f32, normal: u32) -> vec4u {
    let short = depth_unorm16(depth);
    let stored = select(bitcast<u32>(depth), short, level.has_16_bit_depth == 1u);
    return vec4u(paper_coordinate(texel), stored, 0u, (short << 16u) | normal);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn hybrid_place_paper(@builtin(global_invocation_id) id: vec3u) {
    let block = id.xy;
    if (any(block >= vec2u(level.side_texels))) {
        return;
    }
    let normals = block_normals(block);
    var word = hybrid_levels[block_offset(block)];
    var normal = 0u;
    if ((word & ADUMBRA_HYBRID_INDEX) != 0u && block_room(block, word) + level.split_size > level.room) {
        word = level.empty_word;
        hybrid_levels[block_offset(block)] = word;
    } else if ((word & ADUMBRA_HYBRID_INDEX) != 0u) {
        let offset = block_room(block, word);
        let coarsest = level.start_texels >> level.merges;
        let link = offset - ((coarsest * coarsest + 3u) & ~3u);
        var depths: vec4f;
        var words: vec4u;
        if (level.number == 1u) {
            depths = block_depths(block);
        } else {
            words = block_children(block);
        }
        for (var i = 0u; i < 4u; i++) {
            let child = 2u * block + vec2u(i & 1u, i >> 1u);
            if (level.number == 1u) {
                map_texels[offset + i] = paper_finest(child, depths[i], normals[i]);
            } else {
                map_texels[offset + i] = paper_texel(child, words[i], normals[i]);
            }
            map_links[link + i] = vec2u(offset + i, select(link + i + 1u, ADUMBRA_HYBRID_NO_LINK, i == 3u));
        }
        word = ADUMBRA_HYBRID_INDEX | link;
        hybrid_levels[block_offset(block)] = word;
    } else {
        normal = adumbra_hybrid_normal_mean(normals);
    }
    hybrid_normals[block_offset(block)] = normal;
    if (level.number == level.merges) {
        map_texels[block.y * level.side_texels + block.x] = paper_texel(block, word, normal);
    }
}
