// View depth of each texel of an occlusion picture: that of the frame's pixel texel · size.z; 0 where nothing is. One thread a texel.

@group(0) @binding(0) var<uniform> occlusion: OcclusionParams;
@group(0) @binding(1) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(2) var view_depth_out: texture_storage_2d<r32float, write>;

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn occlusion_surface(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= occlusion.size.xy)) {
        return;
    }
    let depth = textureLoad(gbuffer_depth, id.xy * occlusion.size.z, 0);
    let k = occlusion.depth_to_z;
    let z = (k.x + k.y * depth) / (k.z + k.w * depth);
    textureStore(view_depth_out, id.xy, vec4f(select(z, 0.0, depth == 0.0), 0.0, 0.0, 0.0));
}
