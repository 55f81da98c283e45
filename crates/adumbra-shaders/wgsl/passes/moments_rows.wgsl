// Blurs the moments of one layer's depth along rows with a Gaussian. One thread per texel. No other layer is
// read.

@group(0) @binding(1) var map_depth: texture_depth_2d_array;

fn moments_at(texel: vec2i) -> vec4f {
    let column = clamp(texel.x, 0, i32(blur.side_texels) - 1);
    return adumbra_moments_of(textureLoad(map_depth, vec2i(column, texel.y), i32(blur.layer), 0), blur.exponents);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn moments_rows(@builtin(global_invocation_id) id: vec3u) {
    if (all(id.xy < vec2u(blur.side_texels))) {
        blur_moments(vec2i(id.xy), vec2i(1, 0));
    }
}
