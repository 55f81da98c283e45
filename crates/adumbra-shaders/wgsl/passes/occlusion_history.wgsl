// Temporal accumulation: the mean over all frames so far. Each texel's point is reprojected into the previous
// frame, where the accumulated values of the four texels around it are interpolated, without those that are
// off its plane. A point without any such texel was not visible and starts anew. Only the camera's motion is
// known. A moving object counts as previously visible if it is in the plane of the earlier surface there.
// Source: D. Nehab, P. V. Sander, J. Lawrence, N. Tatarchuk, J. R. Isidoro, Accelerating Real-Time Shading
// with Reverse Reprojection Caching, 2007. One thread per texel.

@group(0) @binding(0) var<uniform> occlusion: AdumbraOcclusionParams;
@group(0) @binding(1) var<uniform> history: AdumbraOcclusionHistoryParams;
@group(0) @binding(2) var ambient_in: texture_2d<f32>;
@group(0) @binding(3) var normals: texture_2d<f32>;
@group(0) @binding(4) var history_in: texture_2d<f32>;
@group(0) @binding(5) var ambient_out: texture_storage_2d<rg32float, write>;
// Visibility, view depth, number of frames, 0.
@group(0) @binding(6) var history_out: texture_storage_2d<rgba32float, write>;

// Total bilinear weight of the four texels below which a point's history counts as fewer frames.
const WHOLE_WEIGHT: f32 = 0.25;

// Transforms a point from this frame's view space to the previous frame's.
fn carried(p: vec3f) -> vec3f {
    let q = vec4f(p, 1.0);
    return vec3f(dot(history.x_from_now, q), dot(history.y_from_now, q), dot(history.z_from_now, q));
}

// Returns the visibility and number of frames in the previous frame; no frames if the point was not visible
// there.
fn seen_before(texel: vec2i, z: f32) -> vec2f {
    let p = adumbra_occlusion_point(occlusion.view, texel, z);
    let p_before = carried(p);
    if (history.has_before == 0u || p_before.z <= 0.0) {
        return vec2f(0.0);
    }
    let at = adumbra_occlusion_texel(history.view, p_before);
    let n_world = textureLoad(normals, texel * i32(occlusion.pixels_per_normal), 0).xyz;
    let n = adumbra_occlusion_direction(history.view, n_world);
    // Too far for integers: the conversion would wrap before the test against the picture's bounds.
    if (any(abs(at) > vec2f(65536.0))) {
        return vec2f(0.0);
    }
    let first = vec2i(floor(at));
    let part = at - floor(at);
    let limit = history.tolerance_world + history.tolerance_world_per_depth * p_before.z;
    var sum = vec2f(0.0);
    var weights = 0.0;
    for (var corner = 0; corner < 4; corner++) {
        let step = vec2i(corner & 1, corner >> 1u);
        let other = first + step;
        if (any(other < vec2i(0)) || any(other >= vec2i(occlusion.size))) {
            continue;
        }
        let old = textureLoad(history_in, other, 0);
        let q = adumbra_occlusion_point(history.view, other, old.y);
        if (old.y > 0.0) {
            // Falls from 1 at the limit to 0 at twice the limit, so that rounding never decides.
            let share = saturate(2.0 - abs(dot(q - p_before, n)) / limit);
            let near = select(1.0 - part, part, step == vec2i(1));
            let weight = near.x * near.y * share;
            sum += weight * old.xz;
            weights += weight;
        }
    }
    if (weights <= 0.0) {
        return vec2f(0.0);
    }
    return vec2f(sum.x / weights, sum.y / max(weights, WHOLE_WEIGHT));
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn occlusion_history(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= occlusion.size)) {
        return;
    }
    let now = textureLoad(ambient_in, id.xy, 0).xy;
    var visibility = now.x;
    var frames = 0.0;
    if (now.y > 0.0) {
        let before = seen_before(vec2i(id.xy), now.y);
        frames = min(before.y + 1.0, history.max_frames);
        if (before.y > 0.0) {
            visibility = before.x + (now.x - before.x) / frames;
        }
    }
    textureStore(ambient_out, id.xy, vec4f(visibility, now.y, 0.0, 0.0));
    textureStore(history_out, id.xy, vec4f(visibility, now.y, frames, 0.0));
}
