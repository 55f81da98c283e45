// Depth from the light, one layer a pass: linear, 0 near the sun, 1 far. Casters before the near plane are pressed onto it.
// map_vertex serves opaque casters by position alone; map_masked_* cut by alpha.

@group(0) @binding(0) var<uniform> layer: MapLayer;
@group(1) @binding(0) var<uniform> material: MaterialParams;
@group(1) @binding(1) var color_texture: texture_2d<f32>;
@group(1) @binding(2) var color_sampler: sampler;

fn map_position(position: vec3f, row_x: vec4f, row_y: vec4f, row_z: vec4f) -> vec4f {
    let p = instance_relative(row_x, row_y, row_z, position);
    let u = dot(layer.u_from_relative.xyz, p) + layer.u_from_relative.w;
    let v = dot(layer.v_from_relative.xyz, p) + layer.v_from_relative.w;
    let depth = dot(layer.depth_from_relative.xyz, p) + layer.depth_from_relative.w;
    return vec4f(2.0 * u - 1.0, 1.0 - 2.0 * v, depth, 1.0);
}

@vertex
fn map_vertex(
    @location(0) position: vec3f,
    @location(3) row_x: vec4f,
    @location(4) row_y: vec4f,
    @location(5) row_z: vec4f,
) -> @builtin(position) vec4f {
    return map_position(position, row_x, row_y, row_z);
}

struct MaskedFragment {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
    @location(1) alpha: f32,
}

@vertex
fn map_masked_vertex(
    @location(0) position: vec3f,
    @location(2) uv: vec2f,
    @location(3) row_x: vec4f,
    @location(4) row_y: vec4f,
    @location(5) row_z: vec4f,
    @location(6) color: vec4f,
) -> MaskedFragment {
    return MaskedFragment(map_position(position, row_x, row_y, row_z), uv, color.a);
}

fn map_is_cut(uv: vec2f, interpolated_alpha: f32) -> bool {
    let texel_alpha = textureSampleLevel(color_texture, color_sampler, uv, 0.0).a;
    return material.base_color.a * texel_alpha * vertex_alpha(interpolated_alpha) < material.alpha.x;
}

@fragment
fn map_masked_fragment(f: MaskedFragment) {
    if (map_is_cut(f.uv, f.alpha)) {
        discard;
    }
}
