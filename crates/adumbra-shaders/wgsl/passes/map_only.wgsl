// The technique that is a shadow map alone.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return map_visibility(s);
}
