// Upsamples ambient visibility of half width and height to the frame's size. A texel corresponds to pixel 2 ·
// texel of the frame, so pixels at even positions copy their texel. Other pixels average the two or four
// texels around them, all equally far, weighted by how close these are to the pixel's own surface. If none is
// close, the one nearest in depth is used. One thread per pixel.

@group(0) @binding(0) var<uniform> occlusion: AdumbraOcclusionParams;
@group(0) @binding(1) var<uniform> blur: AdumbraOcclusionFilterParams;
@group(0) @binding(2) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(3) var ambient_in: texture_2d<f32>;
@group(0) @binding(4) var ambient_out: texture_storage_2d<rg32float, write>;

// Smallest sum of weights that is accepted.
const MIN_WEIGHT: f32 = 0.01;

fn depth_at(pixel: vec2i) -> f32 {
    let last = vec2i(textureDimensions(gbuffer_depth)) - 1;
    let depth = textureLoad(gbuffer_depth, clamp(pixel, vec2i(0), last), 0);
    let is_there = depth > 0.0 && all(pixel >= vec2i(0)) && all(pixel <= last);
    return select(0.0, adumbra_stored_view_depth(occlusion.depth_to_z, depth), is_there);
}

fn run_along(pixel: vec2i, axis: vec2i, z: f32) -> vec2f {
    return adumbra_occlusion_run(depth_at(pixel - axis), z, depth_at(pixel + axis), blur.plane_kind, blur.inverse_depth_width);
}

fn visibility_of(pixel: vec2i, z: f32) -> f32 {
    let first = pixel >> vec2u(1u);
    let odd = pixel & vec2i(1);
    if (all(odd == vec2i(0))) {
        return textureLoad(ambient_in, first, 0).x;
    }
    var run_x = vec2f(0.0);
    var run_y = vec2f(0.0);
    if (odd.x == 1) {
        run_x = run_along(pixel, vec2i(1, 0), z);
    }
    if (odd.y == 1) {
        run_y = run_along(pixel, vec2i(0, 1), z);
    }
    let last = min(first + odd, vec2i(occlusion.size) - 1);
    var sum = 0.0;
    var weights = 0.0;
    var nearest = 1.0;
    var smallest = 3.0e38;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let other = textureLoad(ambient_in, vec2i(x, y), 0).xy;
            if (other.y <= 0.0) {
                continue;
            }
            let offset = vec2f(2 * vec2i(x, y) - pixel);
            let run = offset.x * run_x + offset.y * run_y;
            let d = abs(other.y * (1.0 + run.x) - (z + run.y));
            let k = d * blur.inverse_depth_width;
            let weight = exp(-k * k);
            sum += weight * other.x;
            weights += weight;
            if (d < smallest) {
                smallest = d;
                nearest = other.x;
            }
        }
    }
    return select(nearest, sum / max(weights, MIN_WEIGHT), weights >= MIN_WEIGHT);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn occlusion_up(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= textureDimensions(gbuffer_depth))) {
        return;
    }
    let pixel = vec2i(id.xy);
    let z = depth_at(pixel);
    var visibility = 1.0;
    if (z > 0.0) {
        visibility = visibility_of(pixel, z);
    }
    textureStore(ambient_out, id.xy, vec4f(visibility, z, 0.0, 0.0));
}
