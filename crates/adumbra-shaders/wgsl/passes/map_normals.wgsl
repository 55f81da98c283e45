// Depth from the light as passes/map_depth.wgsl draws it and, beside it, the nearest caster's geometric normal: octahedral,
// world space, turned towards the sun. Vertices are three a triangle, so the normal is packed once a vertex.

struct NormalFragment {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) texel: vec2f,
    @location(1) uv: vec2f,
    @location(2) alpha: f32,
}

@vertex
fn map_normals_vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) row_x: vec4f,
    @location(4) row_y: vec4f,
    @location(5) row_z: vec4f,
    @location(6) color: vec4f,
) -> NormalFragment {
    let n = instance_normal(row_x, row_y, row_z, normal);
    let away_from_sun = layer.depth_from_relative.xyz;
    let turned = select(n, -n, dot(n, away_from_sun) > 0.0);
    // A triangle without area has no normal; it covers no texel either.
    let known = select(turned, -away_from_sun, all(n == vec3f(0.0)));
    let texel = octahedral_texel(octahedral_encode(known));
    return NormalFragment(map_position(position, row_x, row_y, row_z), texel, uv, color.a);
}

@fragment
fn map_normals_fragment(f: NormalFragment) -> @location(0) vec2f {
    return f.texel;
}

@fragment
fn map_normals_masked_fragment(f: NormalFragment) -> @location(0) vec2f {
    if (map_is_cut(f.uv, f.alpha)) {
        discard;
    }
    return f.texel;
}
