// Texels of a hybrid map that hold one depth, the mean of the finer ones: a 32-bit float, whose sign bit is 0.
// Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016.

// Depth at the middle, and its change a texel to the right and a texel down.
fn hybrid_leaf(word: u32, unit: i32) -> vec3f {
    return vec3f(bitcast<f32>(word), 0.0, 0.0);
}
