// Depth from the light, one layer per pass: linear, 0 near the sun, 1 far. Casters in front of the near plane
// are clamped to it. map_vertex draws opaque casters from positions alone; map_masked_* also applies the
// alpha test.

@group(0) @binding(0) var<uniform> layer: AdumbraMapLayer;

fn map_position(position: vec3f, row_x: vec4f, row_y: vec4f, row_z: vec4f) -> vec4f {
    let p = adumbra_map_layer_position(layer, adumbra_instance_relative(row_x, row_y, row_z, position));
    return vec4f(2.0 * p.x - 1.0, 1.0 - 2.0 * p.y, p.z, 1.0);
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
fn map_masked_vertex(c: Corner) -> MaskedFragment {
    return MaskedFragment(map_position(c.position, c.row_x, c.row_y, c.row_z), c.uv, c.color.a);
}

@fragment
fn map_masked_fragment(f: MaskedFragment) {
    if (is_cut(f.uv, f.alpha)) {
        discard;
    }
}
