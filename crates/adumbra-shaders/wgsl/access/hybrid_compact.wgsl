// Words of a hybrid map with 32 bits per texel: the coarsest level row by row, then blocks of four children
// each, in the order upper left, upper right, lower left, lower right. The word of a texel with children is
// ADUMBRA_HYBRID_INDEX combined with the offset of its children, which is a multiple of four, or of two for
// 16-bit depths. The finest depths are 32-bit floats, or two 16-bit depths per word with the left one in the
// low half. Two blocks of 16-bit depths share four words.

@group(2) @binding(1) var<storage, read> adumbra_hybrid_words: array<u32>;
// The same words in groups of four.
@group(2) @binding(2) var<storage, read> adumbra_hybrid_fours: array<vec4u>;

fn adumbra_hybrid_root(cell: vec2u, side: u32) -> u32 {
    return adumbra_hybrid_words[cell.y * side + cell.x];
}

// Returns a child above the finest level. `texel` is the child's position in its level.
fn adumbra_hybrid_child(parent: u32, texel: vec2u) -> u32 {
    let child = (texel.x & 1u) + 2u * (texel.y & 1u);
    return adumbra_hybrid_words[(parent ^ ADUMBRA_HYBRID_INDEX) + child];
}

fn adumbra_hybrid_finest(parent: u32, texel: vec2u, halves: bool) -> f32 {
    let offset = parent ^ ADUMBRA_HYBRID_INDEX;
    if (halves) {
        let pair = adumbra_hybrid_words[offset + (texel.y & 1u)];
        return f32(extractBits(pair, 16u * (texel.x & 1u), 16u)) / 65535.0;
    }
    return bitcast<f32>(adumbra_hybrid_words[offset + (texel.x & 1u) + 2u * (texel.y & 1u)]);
}

// Returns the four finest texels of a texel of level 1.
fn adumbra_hybrid_finest_block(parent: u32, block: vec2u, halves: bool) -> vec4f {
    let offset = parent ^ ADUMBRA_HYBRID_INDEX;
    let four = adumbra_hybrid_fours[offset >> 2u];
    if (halves) {
        let pairs = select(four.xy, four.zw, (offset & 2u) != 0u);
        return vec4f(vec4u(pairs.x & 0xffffu, pairs.x >> 16u, pairs.y & 0xffffu, pairs.y >> 16u)) / 65535.0;
    }
    return bitcast<vec4f>(four);
}
