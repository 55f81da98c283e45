// World normals made of depth alone, for engines that store none. Along each axis the side is taken whose two pixels, drawn
// on, come nearest to the middle's depth: so neither an edge nor a crease is smoothed over, as in W. Wu, Accurate Normal
// Reconstruction from Depth Buffer, 2019.
//
// Stored depth d changes evenly over a plane in either projection: in perspective n·P = const is n·(hx X, hy Y, 1) = const
// · d at the point z (hx X, hy Y, 1), hence n ~ (dd/dX / hx, dd/dY / hy, d - X dd/dX - Y dd/dY), away from the viewer. One
// thread a texel.

@group(0) @binding(0) var<uniform> occlusion: OcclusionParams;
@group(0) @binding(1) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(2) var normal_out: texture_storage_2d<rgba32float, write>;

// Larger than the miss of any two depths.
const ONE_PIXEL: f32 = 4.0;
const NO_PIXEL: f32 = 8.0;

// 0 where nothing is.
fn depth_at(pixel: vec2i) -> f32 {
    let last = vec2i(textureDimensions(gbuffer_depth)) - 1;
    let depth = textureLoad(gbuffer_depth, clamp(pixel, vec2i(0), last), 0);
    return select(0.0, depth, all(pixel >= vec2i(0)) && all(pixel <= last));
}

// What depth changes by from the middle to the next pixel of a side, and by how much that side misses the middle.
fn side_of(pixel: vec2i, axis: vec2i, own: f32) -> vec2f {
    let one = depth_at(pixel + axis);
    let two = depth_at(pixel + 2 * axis);
    if (one == 0.0) {
        return vec2f(0.0, NO_PIXEL);
    }
    return vec2f(one - own, select(abs(2.0 * one - two - own), ONE_PIXEL, two == 0.0));
}

// What depth changes by from pixel to pixel.
fn step_along(pixel: vec2i, axis: vec2i, own: f32) -> f32 {
    let before = side_of(pixel, -axis, own);
    let after = side_of(pixel, axis, own);
    return select(after.x, -before.x, before.y < after.y);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn occlusion_normals(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= occlusion.size.xy)) {
        return;
    }
    let pixel = vec2i(id.xy * occlusion.size.z);
    let own = depth_at(pixel);
    var n = vec3f(0.0);
    if (own > 0.0) {
        let steps = vec2f(step_along(pixel, vec2i(1, 0), own), step_along(pixel, vec2i(0, 1), own));
        let per_ndc = steps * f32(occlusion.size.z) / occlusion.ndc_from_texel.xy;
        let ndc = occlusion.ndc_from_texel.xy * vec2f(id.xy) + occlusion.ndc_from_texel.zw;
        let half_view = occlusion.half_view.xy + occlusion.half_view.zw;
        let k = occlusion.depth_to_z;
        var n_view = vec3f(k.y * per_ndc / half_view, -1.0);
        if (k.w != 0.0) {
            n_view = -vec3f(per_ndc / half_view, own - dot(ndc, per_ndc));
        }
        n_view = normalize(n_view);
        n = n_view.x * occlusion.right.xyz + n_view.y * occlusion.up.xyz + n_view.z * occlusion.forward.xyz;
    }
    textureStore(normal_out, id.xy, vec4f(n, 0.0));
}
