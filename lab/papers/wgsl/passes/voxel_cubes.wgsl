// The techniques `voxel-cubes` and `voxel-texture`: a world-aligned tree, filtered over 1, 3³ or 5³ cells.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return adumbra_cubes_factor(cubes.params, s);
}
