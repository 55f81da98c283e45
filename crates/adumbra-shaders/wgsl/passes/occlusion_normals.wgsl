// World normals reconstructed from depth alone, for engines that store none. Along each axis, the side is
// used whose two pixels extrapolate closest to the centre's depth, so that neither edges nor creases are
// smoothed over, as in W. Wu, Accurate Normal Reconstruction from Depth Buffer, 2019.
//
// Over a plane, stored depth d is linear on the screen in either projection. In perspective, n·P = const is
// n·(hx X, hy Y, 1) = const · d at the point z (hx X, hy Y, 1), hence n ~ (dd/dX / hx, dd/dY / hy, d - X
// dd/dX - Y dd/dY), away from the viewer. One thread per texel.

@group(0) @binding(0) var<uniform> occlusion: AdumbraOcclusionParams;
@group(0) @binding(1) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(2) var normal_out: texture_storage_2d<rgba32float, write>;

// Both are larger than the extrapolation error of any two depths.
const ONE_PIXEL: f32 = 4.0;
const NO_PIXEL: f32 = 8.0;

// Returns the stored depth; 0 if there is no surface.
fn depth_at(pixel: vec2i) -> f32 {
    let last = vec2i(textureDimensions(gbuffer_depth)) - 1;
    let depth = textureLoad(gbuffer_depth, clamp(pixel, vec2i(0), last), 0);
    return select(0.0, depth, all(pixel >= vec2i(0)) && all(pixel <= last));
}

// Returns the change of depth from the centre to the next pixel on one side, and the extrapolation error of
// that side.
fn side_of(pixel: vec2i, axis: vec2i, own: f32) -> vec2f {
    let one = depth_at(pixel + axis);
    let two = depth_at(pixel + 2 * axis);
    if (one == 0.0) {
        return vec2f(0.0, NO_PIXEL);
    }
    return vec2f(one - own, select(abs(2.0 * one - two - own), ONE_PIXEL, two == 0.0));
}

// Returns the change of depth per pixel along an axis.
fn step_along(pixel: vec2i, axis: vec2i, own: f32) -> f32 {
    let before = side_of(pixel, -axis, own);
    let after = side_of(pixel, axis, own);
    return select(after.x, -before.x, before.y < after.y);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn occlusion_normals(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= occlusion.size)) {
        return;
    }
    let pixel = vec2i(id.xy * occlusion.pixels_per_texel);
    let own = depth_at(pixel);
    var n = vec3f(0.0);
    if (own > 0.0) {
        let steps = vec2f(step_along(pixel, vec2i(1, 0), own), step_along(pixel, vec2i(0, 1), own));
        let per_ndc = steps * f32(occlusion.pixels_per_texel) / occlusion.view.ndc_per_texel;
        let ndc = adumbra_occlusion_ndc(occlusion.view, vec2i(id.xy));
        let half_view = occlusion.view.half_view + occlusion.view.half_view_per_depth;
        var n_view = vec3f(occlusion.depth_to_z.numerator_slope * per_ndc / half_view, -1.0);
        if (occlusion.depth_to_z.denominator_slope != 0.0) {
            n_view = -vec3f(per_ndc / half_view, own - dot(ndc, per_ndc));
        }
        n_view = normalize(n_view);
        n = n_view.x * occlusion.view.right + n_view.y * occlusion.view.up + n_view.z * occlusion.view.forward;
    }
    textureStore(normal_out, id.xy, vec4f(n, 0.0));
}
