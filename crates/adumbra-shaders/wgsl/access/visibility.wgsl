// The functions that an engine's shader calls. `adumbra_file_factor` and `adumbra_file_soft` are those of
// access/voxel_params.wgsl and voxel_params_soft.wgsl, of access/voxel_levels.wgsl and
// voxel_levels_soft.wgsl, or of access/look_up_file.wgsl.

// Returns the visibility of a point: 1 = lit. Positions are relative to the anchor of the parameters. The
// normal is the triangle's, of unit length, or zero where there is none.
fn adumbra_visibility(p_relative: vec3f, normal: vec3f) -> f32 {
    var s: AdumbraSurface;
    s.p_relative = p_relative;
    s.normal = normal;
    return adumbra_file_factor(s);
}

// Returns the visibility of the sun's disc at a point. The parameters must be those of penumbrae. `pixel`
// rotates the taps.
fn adumbra_soft_visibility(p_relative: vec3f, normal: vec3f, pixel: vec2u) -> f32 {
    var s: AdumbraSurface;
    s.p_relative = p_relative;
    s.normal = normal;
    s.pixel = pixel;
    return adumbra_file_soft(s);
}
