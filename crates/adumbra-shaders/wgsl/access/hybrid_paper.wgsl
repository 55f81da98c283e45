// 128-bit texels of a hybrid map, and the linked lists that lead from a texel to its four finer ones.
// Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, section 2.3, figures 2 and 3.
// Departures: links are indices, not pointers. Of the bit layout, the paper specifies only channel A.
//
// | channel | bits | contents |
// |---|---|---|
// | R | 0 to 15, 16 to 31 | column and row of the texel in its level |
// | G | 0 to 31 | depth: a word of core/hybrid_mean or hybrid_plane; finest: a 32-bit float or the 16 bits of A |
// | B | 31, 0 to 30 | ADUMBRA_HYBRID_INDEX and the first link of the list; 0 if the texel holds a depth |
// | A | 16 to 31 | depth at the texel's centre, 65535 = 1 |
// | A | 0 to 7, 8 to 15 | normal: bytes 0 and 1 of core/octahedral.wgsl, both 0 without a caster |
//
// G and A are 0 in a texel that links to finer ones. The texels are stored with the coarsest level first, row
// by row, then in groups of four the texels that links lead to. A link is the index of a texel and the index
// of the next link, which is ADUMBRA_HYBRID_NO_LINK at the end of a list. Worked value: column 5, row 3 of
// the finest level, depth 0.25, normal (0, 1, 0): 0x00030005, 0x3e800000, 0, 0x4000ff80.

@group(2) @binding(1) var<storage, read> adumbra_hybrid_texels: array<vec4u>;
@group(2) @binding(2) var<storage, read> adumbra_hybrid_links: array<vec2u>;

// Returns the depth word, or ADUMBRA_HYBRID_INDEX combined with the first link.
fn adumbra_hybrid_word(texel: vec4u) -> u32 {
    return select(texel.y, texel.z, (texel.z & ADUMBRA_HYBRID_INDEX) != 0u);
}

// Returns the finer texel at a position in its level. Every list holds all four texels, so its end is never
// reached.
fn adumbra_hybrid_listed(parent: u32, texel: vec2u) -> vec4u {
    let wanted = texel.x | (texel.y << 16u);
    var link = parent ^ ADUMBRA_HYBRID_INDEX;
    var found = vec4u(0u);
    while (link != ADUMBRA_HYBRID_NO_LINK) {
        let listed = adumbra_hybrid_links[link];
        found = adumbra_hybrid_texels[listed.x];
        if (found.x == wanted) {
            break;
        }
        link = listed.y;
    }
    return found;
}

fn adumbra_hybrid_finest_depth(word: u32, halves: bool) -> f32 {
    return select(bitcast<f32>(word), f32(word) / 65535.0, halves);
}

fn adumbra_hybrid_root(cell: vec2u, side: u32) -> u32 {
    return adumbra_hybrid_word(adumbra_hybrid_texels[cell.y * side + cell.x]);
}

// Returns a child above the finest level. `texel` is the child's position in its level.
fn adumbra_hybrid_child(parent: u32, texel: vec2u) -> u32 {
    return adumbra_hybrid_word(adumbra_hybrid_listed(parent, texel));
}

fn adumbra_hybrid_finest(parent: u32, texel: vec2u, halves: bool) -> f32 {
    return adumbra_hybrid_finest_depth(adumbra_hybrid_listed(parent, texel).y, halves);
}

// Returns the four finest texels of a texel of level 1. Walks the list once and places each texel by the
// position that it stores.
fn adumbra_hybrid_finest_block(parent: u32, block: vec2u, halves: bool) -> vec4f {
    var depths = vec4f(0.0);
    var link = parent ^ ADUMBRA_HYBRID_INDEX;
    while (link != ADUMBRA_HYBRID_NO_LINK) {
        let listed = adumbra_hybrid_links[link];
        let texel = adumbra_hybrid_texels[listed.x];
        let child = (texel.x & 1u) + 2u * ((texel.x >> 16u) & 1u);
        depths[child] = adumbra_hybrid_finest_depth(texel.y, halves);
        link = listed.y;
    }
    return depths;
}
