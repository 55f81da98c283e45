// The next mip level of one layer's moments: the mean of 2 × 2 texels. One thread per texel.

@group(0) @binding(0) var moments_in: texture_2d<f32>;
@group(0) @binding(1) var moments_out: AdumbraMomentsOut;

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn moments_mip(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= textureDimensions(moments_out))) {
        return;
    }
    let first = vec2i(2u * id.xy);
    let above = textureLoad(moments_in, first, 0) + textureLoad(moments_in, first + vec2i(1, 0), 0);
    let below = textureLoad(moments_in, first + vec2i(0, 1), 0) + textureLoad(moments_in, first + vec2i(1, 1), 0);
    textureStore(moments_out, vec2i(id.xy), 0.25 * (above + below));
}
