// View depth of each texel of an occlusion picture: that of the frame's pixel texel · pixels_per_texel; 0 if
// there is no surface. One thread per texel.

@group(0) @binding(0) var<uniform> occlusion: AdumbraOcclusionParams;
@group(0) @binding(1) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(2) var view_depth_out: texture_storage_2d<r32float, write>;

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn occlusion_surface(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= occlusion.size)) {
        return;
    }
    let depth = textureLoad(gbuffer_depth, id.xy * occlusion.pixels_per_texel, 0);
    let z = adumbra_stored_view_depth(occlusion.depth_to_z, depth);
    textureStore(view_depth_out, id.xy, vec4f(select(z, 0.0, depth == 0.0), 0.0, 0.0, 0.0));
}
