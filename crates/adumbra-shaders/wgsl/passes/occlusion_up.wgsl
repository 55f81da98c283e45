// Ambient visibility of half width and height brought to the frame's: a texel is its frame's pixel 2 · texel, so even
// pixels have theirs; the others take the two or four about them, all equally far, by how near those lie to the pixel's own
// surface. Where none does, the nearest in depth. One thread a pixel.

@group(0) @binding(0) var<uniform> occlusion: OcclusionParams;
@group(0) @binding(1) var<uniform> blur: OcclusionFilterParams;
@group(0) @binding(2) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(3) var ambient_in: texture_2d<f32>;
@group(0) @binding(4) var ambient_out: texture_storage_2d<rg32float, write>;

// Least weight of all that is an answer.
const LEAST_WEIGHT: f32 = 0.01;

fn depth_at(pixel: vec2i) -> f32 {
    let last = vec2i(textureDimensions(gbuffer_depth)) - 1;
    let depth = textureLoad(gbuffer_depth, clamp(pixel, vec2i(0), last), 0);
    let is_there = depth > 0.0 && all(pixel >= vec2i(0)) && all(pixel <= last);
    let k = occlusion.depth_to_z;
    return select(0.0, (k.x + k.y * depth) / (k.z + k.w * depth), is_there);
}

fn run_along(pixel: vec2i, axis: vec2i, z: f32) -> vec2f {
    return occlusion_run(depth_at(pixel - axis), z, depth_at(pixel + axis), blur.shape.yz, blur.shape.x);
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
    let last = min(first + odd, vec2i(occlusion.size.xy) - 1);
    var sum = 0.0;
    var weights = 0.0;
    var nearest = 1.0;
    var least = 3.0e38;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let other = textureLoad(ambient_in, vec2i(x, y), 0).xy;
            if (other.y <= 0.0) {
                continue;
            }
            let offset = vec2f(2 * vec2i(x, y) - pixel);
            let run = offset.x * run_x + offset.y * run_y;
            let d = abs(other.y * (1.0 + run.x) - (z + run.y));
            let k = d * blur.shape.x;
            let weight = exp(-k * k);
            sum += weight * other.x;
            weights += weight;
            if (d < least) {
                least = d;
                nearest = other.x;
            }
        }
    }
    return select(nearest, sum / max(weights, LEAST_WEIGHT), weights >= LEAST_WEIGHT);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
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
