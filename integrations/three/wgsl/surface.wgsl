// A point of a surface, relative to the anchor of the selected file.

fn adumbra_surface_at(p_world: vec3f, normal: vec3f, pixel: vec2f) -> AdumbraSurface {
    var s: AdumbraSurface;
    s.p_relative = p_world - adumbra_texture_anchor();
    s.normal = normal;
    s.towards_sun = adumbra_texture_towards_sun();
    s.view_depth = 0.0;
    s.pixel = vec2u(max(pixel, vec2f(0.0)));
    return s;
}
