// Texels of a hybrid map that hold a plane. No finer texel below them is behind the plane, and none is
// further in front of it than a tolerance.
//
// | bits | contents |
// |---|---|
// | 0 to 6 | code of the slope along x, two's complement |
// | 7 to 13 | code of the slope along y |
// | 14 to 30 | code c of the depth at the texel's centre: (c + 1) / 2^17 |
// | 31 | 0 |
//
// A slope code q represents the slope sign(q) · q², in multiples of the slope of code 1: fine for planes that
// face the light, coarse for planes at grazing angles. Worked value: with slope_unit = 4096 (a step of 2^-24
// per texel) the word 0x40000183 holds depth 65537 / 131072 and slopes of 9 steps (q = 3) along both x and y.

fn adumbra_hybrid_slope_code(word: u32, first: u32) -> i32 {
    return extractBits(bitcast<i32>(word), first, 7u);
}

// Returns the change of depth per texel, in steps of 1 / ADUMBRA_HYBRID_ONE.
fn adumbra_hybrid_slope(code: i32, unit: i32) -> i32 {
    let size = (code * code * unit) >> ADUMBRA_HYBRID_SLOPE_BITS;
    return select(size, -size, code < 0);
}

// Returns the depth at the texel's centre, in steps of 1 / ADUMBRA_HYBRID_ONE.
fn adumbra_hybrid_middle(word: u32) -> i32 {
    return (i32(word >> 14u) + 1) * ADUMBRA_HYBRID_DEPTH_STEP;
}

// Returns the depth at the texel's centre, and its change per texel to the right and per texel downwards.
fn adumbra_hybrid_leaf(word: u32, unit: i32) -> vec3f {
    let x = adumbra_hybrid_slope(adumbra_hybrid_slope_code(word, 0u), unit);
    let y = adumbra_hybrid_slope(adumbra_hybrid_slope_code(word, 7u), unit);
    return vec3f(vec3i(adumbra_hybrid_middle(word), x, y)) / ADUMBRA_HYBRID_ONE;
}
