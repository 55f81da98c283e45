// No shadows: everything that faces the sun is lit.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return 1.0;
}
