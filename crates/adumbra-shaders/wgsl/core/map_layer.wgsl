// A point's position in a layer of a shadow map.

// Applies one row of an affine transformation.
fn adumbra_affine(row: vec4f, p: vec3f) -> f32 {
    return dot(row.xyz, p) + row.w;
}

// Returns u and v, 0 to 1 from left to right and from top to bottom, and depth, 0 near the sun to 1 far.
fn adumbra_map_layer_position(layer: AdumbraMapLayer, p_relative: vec3f) -> vec3f {
    return vec3f(
        adumbra_affine(layer.u_from_relative, p_relative),
        adumbra_affine(layer.v_from_relative, p_relative),
        adumbra_affine(layer.depth_from_relative, p_relative),
    );
}
