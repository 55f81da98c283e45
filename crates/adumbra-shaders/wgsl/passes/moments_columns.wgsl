// Blurs the moments of one layer along columns with a Gaussian. One thread per texel.

@group(0) @binding(1) var moments_in: texture_2d<f32>;

fn moments_at(texel: vec2i) -> vec4f {
    return textureLoad(moments_in, vec2i(texel.x, clamp(texel.y, 0, i32(blur.side_texels) - 1)), 0);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn moments_columns(@builtin(global_invocation_id) id: vec3u) {
    if (all(id.xy < vec2u(blur.side_texels))) {
        blur_moments(vec2i(id.xy), vec2i(0, 1));
    }
}
