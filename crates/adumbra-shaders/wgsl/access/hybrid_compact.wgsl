// Words of a hybrid map of 32 bits a texel: the coarsest level row by row, then blocks of four children: left above, right above, left
// below, right below. HYBRID_INDEX and a word's place is where the children of a texel begin, a multiple of four; of two for 16-bit depths. Finest depths are
// 32-bit floats, or two of 16 bits a word, the left one low; two such blocks share four words.

@group(2) @binding(1) var<storage, read> hybrid_words: array<u32>;
// The same words.
@group(2) @binding(2) var<storage, read> hybrid_fours: array<vec4u>;

fn hybrid_root(cell: vec2u, side: u32) -> u32 {
    return hybrid_words[cell.y * side + cell.x];
}

// A child that is no finest texel; `texel` is its place in its level.
fn hybrid_child(parent: u32, texel: vec2u) -> u32 {
    let child = (texel.x & 1u) + 2u * (texel.y & 1u);
    return hybrid_words[(parent ^ HYBRID_INDEX) + child];
}

fn hybrid_finest(parent: u32, texel: vec2u, halves: bool) -> f32 {
    let place = parent ^ HYBRID_INDEX;
    if (halves) {
        let pair = hybrid_words[place + (texel.y & 1u)];
        return f32(extractBits(pair, 16u * (texel.x & 1u), 16u)) / 65535.0;
    }
    return bitcast<f32>(hybrid_words[place + (texel.x & 1u) + 2u * (texel.y & 1u)]);
}

// All four finest texels of a texel of level 1.
fn hybrid_finest_block(parent: u32, block: vec2u, halves: bool) -> vec4f {
    let place = parent ^ HYBRID_INDEX;
    let four = hybrid_fours[place >> 2u];
    if (halves) {
        let pairs = select(four.xy, four.zw, (place & 2u) != 0u);
        return vec4f(vec4u(pairs.x & 0xffffu, pairs.x >> 16u, pairs.y & 0xffffu, pairs.y >> 16u)) / 65535.0;
    }
    return bitcast<vec4f>(four);
}
