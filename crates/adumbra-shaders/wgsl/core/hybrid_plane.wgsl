// Texels of a hybrid map that hold a plane: no finer texel below them lies behind it, and none further before it than a tolerance.
//
// | bits | hold |
// |---|---|
// | 0 to 6 | code of the slope along x, two's complement |
// | 7 to 13 | code of the slope along y |
// | 14 to 30 | code c of the depth at the texel's middle: (c + 1) / 2^17 |
// | 31 | 0 |
//
// A slope code q stands for sign(q) · q² slopes of code 1: fine where planes face the light, coarse where they graze it. Worked value: with
// slope.x = 4096 (a step of 2^-24 a texel) the word 0x40000183 holds depth 65537 / 131072, slopes of 9 steps (q = 3) along x and
// 9 (q = 3) along y.

fn hybrid_slope_code(word: u32, first: u32) -> i32 {
    return extractBits(bitcast<i32>(word), first, 7u);
}

// Change of depth a texel, in steps of 1 / HYBRID_ONE.
fn hybrid_slope(code: i32, unit: i32) -> i32 {
    let size = (code * code * unit) >> HYBRID_SLOPE_BITS;
    return select(size, -size, code < 0);
}

// Depth at the texel's middle, in the same steps.
fn hybrid_middle(word: u32) -> i32 {
    return (i32(word >> 14u) + 1) * HYBRID_DEPTH_STEP;
}

// Depth at the middle, and its change a texel to the right and a texel down.
fn hybrid_leaf(word: u32, unit: i32) -> vec3f {
    let x = hybrid_slope(hybrid_slope_code(word, 0u), unit);
    let y = hybrid_slope(hybrid_slope_code(word, 7u), unit);
    return vec3f(vec3i(hybrid_middle(word), x, y)) / HYBRID_ONE;
}
