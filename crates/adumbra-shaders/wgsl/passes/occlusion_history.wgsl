// The mean of the frames so far: each texel's point is carried into the frame before and meets what that frame, and those
// before it, knew of it: the four texels about it, less those that lie off its plane. What has no such texel was not seen,
// and begins anew. The camera moves; of what moves in the scene nothing is known: it counts as seen where it lies in the
// plane of what was there. After D. Nehab, P. V. Sander, J. Lawrence, N. Tatarchuk, J. R. Isidoro, Accelerating Real-Time
// Shading with Reverse Reprojection Caching, 2007. One thread a texel.

@group(0) @binding(0) var<uniform> occlusion: OcclusionParams;
@group(0) @binding(1) var<uniform> history: OcclusionHistoryParams;
@group(0) @binding(2) var ambient_in: texture_2d<f32>;
@group(0) @binding(3) var normals: texture_2d<f32>;
@group(0) @binding(4) var history_in: texture_2d<f32>;
@group(0) @binding(5) var ambient_out: texture_storage_2d<rg32float, write>;
// Visibility, view depth, frames, 0.
@group(0) @binding(6) var history_out: texture_storage_2d<rgba32float, write>;

// Share of the four texels, by their distance, below which what is known of a point counts as fewer frames.
const WHOLE_WEIGHT: f32 = 0.25;

// A point of this frame's view space in that of the frame before.
fn carried(p: vec3f) -> vec3f {
    let q = vec4f(p, 1.0);
    return vec3f(dot(history.before_x, q), dot(history.before_y, q), dot(history.before_z, q));
}

// Visibility and frames of the frame before; no frames where it did not see the point.
fn seen_before(texel: vec2i, z: f32) -> vec2f {
    let p = occlusion_point(occlusion.ndc_from_texel, occlusion.half_view, texel, z);
    let p_before = carried(p);
    if (history.limits.w == 0.0 || p_before.z <= 0.0) {
        return vec2f(0.0);
    }
    let at = occlusion_texel(history.ndc_from_texel, history.half_view, p_before);
    let n_world = textureLoad(normals, texel * i32(occlusion.size.w), 0).xyz;
    let n = vec3f(
        dot(n_world, history.right.xyz),
        dot(n_world, history.up.xyz),
        dot(n_world, history.forward.xyz),
    );
    // Too far for whole numbers, which the test against the picture would then see wrapped.
    if (any(abs(at) > vec2f(65536.0))) {
        return vec2f(0.0);
    }
    let first = vec2i(floor(at));
    let part = at - floor(at);
    let limit = history.limits.x + history.limits.y * p_before.z;
    var sum = vec2f(0.0);
    var weights = 0.0;
    for (var corner = 0; corner < 4; corner++) {
        let step = vec2i(corner & 1, corner >> 1u);
        let other = first + step;
        if (any(other < vec2i(0)) || any(other >= vec2i(occlusion.size.xy))) {
            continue;
        }
        let old = textureLoad(history_in, other, 0);
        let q = occlusion_point(history.ndc_from_texel, history.half_view, other, old.y);
        if (old.y > 0.0) {
            // Falls from one at the limit to none at twice the limit, so that rounding decides nothing.
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

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn occlusion_history(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= occlusion.size.xy)) {
        return;
    }
    let now = textureLoad(ambient_in, id.xy, 0).xy;
    var visibility = now.x;
    var frames = 0.0;
    if (now.y > 0.0) {
        let before = seen_before(vec2i(id.xy), now.y);
        frames = min(before.y + 1.0, history.limits.z);
        if (before.y > 0.0) {
            visibility = before.x + (now.x - before.x) / frames;
        }
    }
    textureStore(ambient_out, id.xy, vec4f(visibility, now.y, 0.0, 0.0));
    textureStore(history_out, id.xy, vec4f(visibility, now.y, frames, 0.0));
}
