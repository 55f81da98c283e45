// Depth from the light as in passes/map_depth.wgsl, together with the nearest caster's geometric normal:
// octahedral, in world space, facing the sun. There are three vertices per triangle, so the normal is packed
// once per vertex.

struct NormalFragment {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) texel: vec2f,
    @location(1) uv: vec2f,
    @location(2) alpha: f32,
}

@vertex
fn map_normals_vertex(c: Corner) -> NormalFragment {
    let n = adumbra_instance_normal(c.row_x, c.row_y, c.row_z, c.normal);
    let away_from_sun = layer.depth_from_relative.xyz;
    let turned = select(n, -n, dot(n, away_from_sun) > 0.0);
    // A triangle without area has no normal, but it covers no texel either.
    let known = select(turned, -away_from_sun, all(n == vec3f(0.0)));
    let texel = adumbra_octahedral_texel(adumbra_octahedral_encode(known));
    return NormalFragment(map_position(c.position, c.row_x, c.row_y, c.row_z), texel, c.uv, c.color.a);
}

@fragment
fn map_normals_fragment(f: NormalFragment) -> @location(0) vec2f {
    return f.texel;
}

@fragment
fn map_normals_masked_fragment(f: NormalFragment) -> @location(0) vec2f {
    if (is_cut(f.uv, f.alpha)) {
        discard;
    }
    return f.texel;
}
