// The level at which a look-up in a tree ends; -1 outside the file.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return f32(adumbra_cubes_end_level(cubes.params, s));
}
