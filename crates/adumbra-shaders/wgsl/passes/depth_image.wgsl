// Writes a depth image into a layer of a shadow map, as if the casters had been drawn, with one triangle over
// all texels.

@group(0) @binding(0) var depth_image: texture_2d<f32>;

@vertex
fn depth_image_vertex(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    let place = vec2f(f32(corner & 1u), f32(corner >> 1u));
    return vec4f(4.0 * place - 1.0, 0.0, 1.0);
}

@fragment
fn depth_image_fragment(@builtin(position) position: vec4f) -> @builtin(frag_depth) f32 {
    return textureLoad(depth_image, vec2u(position.xy), 0).x;
}
