// Texels of a hybrid map that hold one depth, the mean of the finer ones, as a 32-bit float with sign bit 0.
// Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016.

// Returns the depth at the texel's centre, and its change per texel to the right and per texel downwards.
fn adumbra_hybrid_leaf(word: u32, unit: i32) -> vec3f {
    return vec3f(bitcast<f32>(word), 0.0, 0.0);
}
