// The techniques `voxel-cubes` and `voxel-texture`: a world-aligned tree, filtered over 1, 3³ or 5³ cells.

fn shadow_factor(s: Surface) -> f32 {
    return cubes_factor(cubes.params, s);
}
