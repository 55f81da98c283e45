// Ambient visibility of each texel: the pass around an estimator, which is a function
//     fn ambient_visibility(c: OcclusionCenter) -> f32      1 = unoccluded
// in a file of its own. Writes visibility and view depth, so that filters read one texture. One thread a texel.

@group(0) @binding(0) var<uniform> occlusion: OcclusionParams;
@group(0) @binding(1) var<uniform> noise: OcclusionTaps;
@group(0) @binding(2) var view_depths: texture_2d<f32>;
@group(0) @binding(3) var normals: texture_2d<f32>;
@group(0) @binding(4) var ambient_out: texture_storage_2d<rg32float, write>;

fn is_inside(texel: vec2i) -> bool {
    return all(texel >= vec2i(0)) && all(texel < vec2i(occlusion.size.xy));
}

// 0 where nothing is. The texel is inside.
fn view_depth_at(texel: vec2i) -> f32 {
    return textureLoad(view_depths, texel, 0).x;
}

fn point_at(texel: vec2i, z: f32) -> vec3f {
    return occlusion_point(occlusion.ndc_from_texel, occlusion.half_view, texel, z);
}

fn center_at(texel: vec2u, z: f32) -> OcclusionCenter {
    let n = textureLoad(normals, texel * occlusion.size.w, 0).xyz;
    let n_view = vec3f(dot(n, occlusion.right.xyz), dot(n, occlusion.up.xyz), dot(n, occlusion.forward.xyz));
    var c: OcclusionCenter;
    c.texel = vec2i(texel);
    c.p = point_at(c.texel, z);
    c.n = normalize(n_view);
    let texels = occlusion.region.x / (occlusion.region.z + occlusion.region.w * z);
    // The region shrinks as a whole: what lies in it weighs as in a region of that size, and nothing is cut off.
    let share = min(1.0, occlusion.region.y / texels);
    c.radius_texels = texels * share;
    c.radius_world = occlusion.region.x * share;
    let place = (occlusion_place(texel) + occlusion.counts.z) & 15u;
    c.first_tap = place * OCCLUSION_MAX_TAPS;
    return c;
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn occlude(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= occlusion.size.xy)) {
        return;
    }
    let z = view_depth_at(vec2i(id.xy));
    var visibility = 1.0;
    if (z > 0.0) {
        let c = center_at(id.xy, z);
        if (c.radius_texels >= 0.5) {
            visibility = ambient_visibility(c);
        }
    }
    textureStore(ambient_out, id.xy, vec4f(visibility, z, 0.0, 0.0));
}
