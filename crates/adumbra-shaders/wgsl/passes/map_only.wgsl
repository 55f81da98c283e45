// The technique that is a shadow map and nothing else.

fn shadow_factor(s: Surface) -> f32 {
    return map_visibility(s);
}
