// The blend of a streamed file's levels: while pages fade, a level's answer has a share, and the next coarser
// level has the remainder. core/voxel.wgsl must precede this file. This is the counterpart of
// adumbra::stream::PoolSampler. Source: spec/streaming.md.

// Returns the weight of a level's answer to a receiver, 0 to 1: the smallest weight of the pages that the
// filter or the largest penumbra may reach.
fn adumbra_depths_weight(v: AdumbraVoxelParams, r: AdumbraVoxelReceiver) -> f32 {
    let of_penumbra = v.max_radius_texels * vec2f(length(v.penumbra_x), length(v.penumbra_y));
    let reach = max(vec2i(of_penumbra) + select(0, 2, v.max_radius_texels > 0.0), vec2i(i32(v.filter_width >> 1u)));
    let texel = r.p_fixed.xy >> vec2u(ADUMBRA_FIXED_BITS);
    let last = v.grid.size.xy - 1;
    let low = clamp(texel - reach, vec2i(0), last) >> vec2u(ADUMBRA_PAGE_LEVEL);
    let high = clamp(texel + reach, vec2i(0), last) >> vec2u(ADUMBRA_PAGE_LEVEL);
    let across = (last.x >> ADUMBRA_PAGE_LEVEL) + 1;
    let first = v.extra.x + 2u * v.root_count.x * v.root_count.y;
    var weight = ADUMBRA_WHOLE_PAGE;
    for (var y = low.y; y <= high.y; y++) {
        for (var x = low.x; x <= high.x; x++) {
            weight = min(weight, adumbra_voxel_word(first + u32(y * across + x)));
        }
    }
    return f32(weight) / f32(ADUMBRA_WHOLE_PAGE);
}

// Adds a level's visibility, negative if it lacks a page, to a blend: the sum so far, and the share that is
// left to coarser levels. A blend begins as (0, 1), and is complete when the share is 0.
fn adumbra_blend(blend: vec2f, v: AdumbraVoxelParams, s: AdumbraSurface, lit: f32) -> vec2f {
    if (lit < 0.0) {
        return blend;
    }
    var share = blend.y;
    if (v.extra.z == ADUMBRA_PAGES_FADE) {
        share *= adumbra_depths_weight(v, adumbra_voxel_receiver(v, s));
    }
    return vec2f(blend.x + share * lit, blend.y - share);
}
