fn adumbra_texture_width() -> u32 {
    return words::width();
}

fn adumbra_texture_texel(at: vec2<u32>) -> u32 {
    return words::texel(at);
}

fn surface_at(p_world: vec3<f32>, normal: vec3<f32>, towards_sun: vec3<f32>, pixel: vec2<f32>) -> AdumbraSurface {
    var s: AdumbraSurface;
    s.p_relative = p_world - adumbra_texture_anchor();
    s.normal = normal;
    s.towards_sun = towards_sun;
    s.view_depth = 0.0;
    s.pixel = vec2<u32>(max(pixel, vec2<f32>(0.0)));
    return s;
}

// Returns how far inside the selected file's grid a point is, texels; negative outside.
fn texels_inside(p_world: vec3<f32>, towards_sun: vec3<f32>) -> i32 {
    adumbra_finest_level();
    let v = adumbra_texture_params();
    let r = adumbra_voxel_receiver(v, surface_at(p_world, vec3<f32>(0.0), towards_sun, vec2<f32>(0.0)));
    let texel = r.p_fixed.xy >> vec2<u32>(ADUMBRA_FIXED_BITS);
    let to_border = min(texel, v.grid.size.xy - 1 - texel);
    return min(to_border.x, to_border.y);
}
