// Children of blocks that did not merge to their places in a map of the paper's layout, their links, and the coarsest level;
// beside that the normal of each block that merged; one thread a block. Texels are packed as access/hybrid_paper.wgsl says.

@group(1) @binding(0) var start_normals: texture_2d_array<f32>;
@group(1) @binding(1) var<storage, read_write> hybrid_texels: array<vec4u>;
@group(1) @binding(2) var<storage, read_write> hybrid_links: array<vec2u>;
// Packed, of blocks as hybrid_levels has their words; 0 where a block did not merge.
@group(1) @binding(3) var<storage, read_write> hybrid_normals: array<u32>;

fn start_normal(texel: vec2u) -> u32 {
    let bytes = octahedral_bytes(textureLoad(start_normals, texel, 0, 0).xy);
    return bytes.x | (bytes.y << 8u);
}

// Of a block's children: left above, right above, left below, right below.
fn block_normals(block: vec2u) -> vec4u {
    if (level.counts.y == 1u) {
        let t = 2u * block;
        return vec4u(
            start_normal(t),
            start_normal(t + vec2u(1u, 0u)),
            start_normal(t + vec2u(0u, 1u)),
            start_normal(t + vec2u(1u, 1u)),
        );
    }
    let row = 2u * level.counts.z;
    let first = level.places.x + 2u * block.y * row + 2u * block.x;
    let below = first + row;
    return vec4u(hybrid_normals[first], hybrid_normals[first + 1u], hybrid_normals[below], hybrid_normals[below + 1u]);
}

// The nearest of 65,536 depths, in whole numbers: every machine finds the same.
fn depth_unorm16(depth: f32) -> u32 {
    let steps = i32(depth * HYBRID_ONE);
    return u32((steps + ((i32(0.5 * HYBRID_ONE) - steps) >> 16u)) >> 8u);
}

fn paper_coordinate(texel: vec2u) -> u32 {
    return texel.x | (texel.y << 16u);
}

fn paper_texel(texel: vec2u, word: u32, normal: u32) -> vec4u {
    if ((word & HYBRID_INDEX) != 0u) {
        return vec4u(paper_coordinate(texel), 0u, word, 0u);
    }
    let depth = hybrid_leaf(word, level.plane.x).x;
    return vec4u(paper_coordinate(texel), word, 0u, (depth_unorm16(depth) << 16u) | normal);
}

fn paper_finest(texel: vec2u, depth: f32, normal: u32) -> vec4u {
    let short = depth_unorm16(depth);
    let stored = select(bitcast<u32>(depth), short, level.places.w == 1u);
    return vec4u(paper_coordinate(texel), stored, 0u, (short << 16u) | normal);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn hybrid_place_paper(@builtin(global_invocation_id) id: vec3u) {
    let block = id.xy;
    if (any(block >= level.counts.zz)) {
        return;
    }
    let normals = block_normals(block);
    var word = hybrid_levels[block_place(block)];
    var normal = 0u;
    if ((word & HYBRID_INDEX) != 0u && block_room(block, word) + level.places.z > level.room.x) {
        word = level.room.y;
        hybrid_levels[block_place(block)] = word;
    } else if ((word & HYBRID_INDEX) != 0u) {
        let place = block_room(block, word);
        let coarsest = level.counts.x >> level.counts.w;
        let link = place - ((coarsest * coarsest + 3u) & ~3u);
        var depths: vec4f;
        var words: vec4u;
        if (level.counts.y == 1u) {
            depths = block_depths(block);
        } else {
            words = block_children(block);
        }
        for (var i = 0u; i < 4u; i++) {
            let child = 2u * block + vec2u(i & 1u, i >> 1u);
            if (level.counts.y == 1u) {
                hybrid_texels[place + i] = paper_finest(child, depths[i], normals[i]);
            } else {
                hybrid_texels[place + i] = paper_texel(child, words[i], normals[i]);
            }
            hybrid_links[link + i] = vec2u(place + i, select(link + i + 1u, HYBRID_NO_LINK, i == 3u));
        }
        word = HYBRID_INDEX | link;
        hybrid_levels[block_place(block)] = word;
    } else {
        normal = hybrid_normal_mean(normals);
    }
    hybrid_normals[block_place(block)] = normal;
    if (level.counts.y == level.counts.w) {
        hybrid_texels[block.y * level.counts.z + block.x] = paper_texel(block, word, normal);
    }
}
