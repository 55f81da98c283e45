// Packs a unit vector into two bytes: projected onto the octahedron |x| + |y| + |z| = 1, with the lower half
// folded over the upper one. Source: Cigolle, Donow, Evangelakos, Mara, McGuire, Meyer, A Survey of Efficient
// Representations for Independent Unit Vectors, 2014. Departure: components are rounded to nearest, the
// survey's plain variant. The error is at most 0.95 degrees.
//
// | byte | value |
// |---|---|
// | 0 | 128 + 127 x', rounded to nearest; 1 to 255 |
// | 1 | 128 + 127 y', rounded to nearest; 1 to 255 |
//
// Axes are exact. No byte of a packed vector is 0, so (0, 0) can represent the absence of a vector. Worked
// values: (0, 0, 1) is (128, 128); (0, 1, 0) is (128, 255); (0.6, 0, -0.8) has x' = 1, y' = 0.5714 and is
// (255, 201).

// `n` need not be of length 1, but must not be zero.
fn adumbra_octahedral_encode(n: vec3f) -> vec2u {
    let flat_xy = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let signs = select(vec2f(-1.0), vec2f(1.0), flat_xy >= vec2f(0.0));
    let folded = select(flat_xy, (1.0 - abs(flat_xy.yx)) * signs, n.z < 0.0);
    return vec2u(floor(127.0 * folded + 128.5));
}

// Returns a unit vector.
fn adumbra_octahedral_decode(bytes: vec2u) -> vec3f {
    let e = (vec2f(bytes) - 128.0) / 127.0;
    let z = 1.0 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0.0);
    return normalize(vec3f(e - select(vec2f(-fold), vec2f(fold), e >= vec2f(0.0)), z));
}

// Conversion to and from a texel with two 8-bit unorm channels.
fn adumbra_octahedral_texel(bytes: vec2u) -> vec2f {
    return vec2f(bytes) / 255.0;
}

fn adumbra_octahedral_bytes(texel: vec2f) -> vec2u {
    return vec2u(floor(255.0 * texel + 0.5));
}
