// The mean of normals, each packed into the low and the high byte of a word as in core/octahedral.wgsl; 0
// means none. Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, algorithm 1, which
// stores a normal with each merged texel. The arithmetic is in integers, so that every machine packs the same
// bytes.

// Returns the largest integer whose square is at most `square`, which must be below 2^31.
fn adumbra_whole_root(square: u32) -> u32 {
    var root = u32(sqrt(f32(square)));
    while (root * root > square) {
        root--;
    }
    while ((root + 1u) * (root + 1u) <= square) {
        root++;
    }
    return root;
}

// Returns the unpacked normal with length 2^14.
fn adumbra_hybrid_normal(bytes: u32) -> vec3i {
    let e = vec2i(vec2u(bytes & 255u, bytes >> 8u)) - 128;
    let z = 127 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0);
    let n = vec3i(e - select(vec2i(-fold), vec2i(fold), e >= vec2i(0)), z);
    let square = u32(n.x * n.x + n.y * n.y + n.z * n.z);
    // 256 times the length of n, which is at most 127.
    return (n << vec3u(22u)) / i32(adumbra_whole_root(square << 16u));
}

// Returns the mean of the normals that are present; 0 if there are none or if they cancel out.
fn adumbra_hybrid_normal_mean(normals: vec4u) -> u32 {
    var sum = vec3i(0);
    for (var i = 0u; i < 4u; i++) {
        if (normals[i] != 0u) {
            sum += adumbra_hybrid_normal(normals[i]);
        }
    }
    let size = abs(sum.x) + abs(sum.y) + abs(sum.z);
    if (size == 0) {
        return 0u;
    }
    let signs = select(vec2i(-1), vec2i(1), sum.xy >= vec2i(0));
    let folded = select(sum.xy, (size - abs(sum.yx)) * signs, sum.z < 0);
    // 128 + 127 folded / size, rounded to nearest.
    let bytes = vec2u((254 * folded + 257 * size) / (2 * size));
    return bytes.x | (bytes.y << 8u);
}
