// The mean of normals that are two bytes each, as core/octahedral.wgsl packs them: low and high byte of a word; 0 is none.
// Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, algorithm 1, which stores a normal with what
// merged. In whole numbers: every machine packs the same bytes.

// Largest whole number whose square is no more than `square`, which is below 2^31.
fn whole_root(square: u32) -> u32 {
    var root = u32(sqrt(f32(square)));
    while (root * root > square) {
        root--;
    }
    while ((root + 1u) * (root + 1u) <= square) {
        root++;
    }
    return root;
}

// Of length 2^14.
fn hybrid_normal(bytes: u32) -> vec3i {
    let e = vec2i(vec2u(bytes & 255u, bytes >> 8u)) - 128;
    let z = 127 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0);
    let n = vec3i(e - select(vec2i(-fold), vec2i(fold), e >= vec2i(0)), z);
    let square = u32(n.x * n.x + n.y * n.y + n.z * n.z);
    // 256 lengths of n, which is at most 127 long.
    return (n << vec3u(22u)) / i32(whole_root(square << 16u));
}

// The mean of those that are there; none where no one is, or where they cancel.
fn hybrid_normal_mean(normals: vec4u) -> u32 {
    var sum = vec3i(0);
    for (var i = 0u; i < 4u; i++) {
        if (normals[i] != 0u) {
            sum += hybrid_normal(normals[i]);
        }
    }
    let size = abs(sum.x) + abs(sum.y) + abs(sum.z);
    if (size == 0) {
        return 0u;
    }
    let signs = select(vec2i(-1), vec2i(1), sum.xy >= vec2i(0));
    let folded = select(sum.xy, (size - abs(sum.yx)) * signs, sum.z < 0);
    // 128 + 127 folded / size, to the nearest.
    let bytes = vec2u((254 * folded + 257 * size) / (2 * size));
    return bytes.x | (bytes.y << 8u);
}
