// No shadows: what faces the sun is lit.

fn shadow_factor(s: Surface) -> f32 {
    return 1.0;
}
