// Texels of a hybrid map of 128 bits, and the lists that lead from a texel to its four finer ones.
// Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, section 2.3, figures 2 and 3.
// Departures: links are numbers, not pointers; of bits the paper gives those of A alone.
//
// | channel | bits | hold |
// |---|---|---|
// | R | 0 to 15, 16 to 31 | column and row of the texel in its level |
// | G | 0 to 31 | depth: a word of core/hybrid_mean or hybrid_plane; at finest texels a 32-bit float, or A's 16 bits |
// | B | 31, 0 to 30 | HYBRID_INDEX and the first link of its list; 0 where it holds a depth |
// | A | 16 to 31 | depth at its middle, 65535 = 1 |
// | A | 0 to 7, 8 to 15 | normal: bytes 0 and 1 of core/octahedral.wgsl, both 0 where there is no caster |
//
// G and A of a texel that leads to others are 0. Texels: the coarsest level row by row, then those that links lead to, four by
// four. A link is the number of a texel and that of the next link, HYBRID_NO_LINK in a list's last. Worked value: column 5,
// row 3 of the finest level, depth 0.25, normal (0, 1, 0): 0x00030005, 0x3e800000, 0, 0x4000ff80.

@group(2) @binding(1) var<storage, read> hybrid_texels: array<vec4u>;
@group(2) @binding(2) var<storage, read> hybrid_links: array<vec2u>;

// The depth's word, or HYBRID_INDEX and the first link.
fn hybrid_word(texel: vec4u) -> u32 {
    return select(texel.y, texel.z, (texel.z & HYBRID_INDEX) != 0u);
}

// The finer texel at a place of its level. Every list holds all four, so its end is never reached.
fn hybrid_listed(parent: u32, texel: vec2u) -> vec4u {
    let wanted = texel.x | (texel.y << 16u);
    var link = parent ^ HYBRID_INDEX;
    var found = vec4u(0u);
    while (link != HYBRID_NO_LINK) {
        let listed = hybrid_links[link];
        found = hybrid_texels[listed.x];
        if (found.x == wanted) {
            break;
        }
        link = listed.y;
    }
    return found;
}

fn hybrid_finest_depth(word: u32, halves: bool) -> f32 {
    return select(bitcast<f32>(word), f32(word) / 65535.0, halves);
}

fn hybrid_root(cell: vec2u, side: u32) -> u32 {
    return hybrid_word(hybrid_texels[cell.y * side + cell.x]);
}

// A child that is no finest texel; `texel` is its place in its level.
fn hybrid_child(parent: u32, texel: vec2u) -> u32 {
    return hybrid_word(hybrid_listed(parent, texel));
}

fn hybrid_finest(parent: u32, texel: vec2u, halves: bool) -> f32 {
    return hybrid_finest_depth(hybrid_listed(parent, texel).y, halves);
}

// All four finest texels of a texel of level 1: the list once, each to where it says that it is.
fn hybrid_finest_block(parent: u32, block: vec2u, halves: bool) -> vec4f {
    var depths = vec4f(0.0);
    var link = parent ^ HYBRID_INDEX;
    while (link != HYBRID_NO_LINK) {
        let listed = hybrid_links[link];
        let texel = hybrid_texels[listed.x];
        let child = (texel.x & 1u) + 2u * ((texel.x >> 16u) & 1u);
        depths[child] = hybrid_finest_depth(texel.y, halves);
        link = listed.y;
    }
    return depths;
}
