// The level at which a look-up in a tree ends; -1 beside the file.

fn shadow_factor(s: Surface) -> f32 {
    return f32(cubes_end_level(cubes.params, s));
}
