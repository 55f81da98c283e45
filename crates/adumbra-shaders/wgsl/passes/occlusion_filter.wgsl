// Filters of ambient visibility. The bilateral filter (Qiu et al. 2014, equation 7) has weights that fall
// with the distance of the texels and with the difference of their view depths, each as exp(-(difference /
// sigma)² / 2). Departures: two line passes may replace the square; the difference may be taken from the
// centre's own surface (adumbra_occlusion_run). Visibility and view depth come from one texture. Sky never
// counts and is left unchanged. One thread per texel.

@group(0) @binding(0) var<uniform> blur: AdumbraOcclusionFilterParams;
@group(0) @binding(1) var ambient_in: texture_2d<f32>;
@group(0) @binding(2) var ambient_out: texture_storage_2d<rg32float, write>;

fn ambient_at(texel: vec2i) -> vec2f {
    return textureLoad(ambient_in, texel, 0).xy;
}

// Returns (0, 0) outside the picture.
fn ambient_near(texel: vec2i) -> vec2f {
    let last = vec2i(blur.size) - 1;
    let is_inside = all(texel >= vec2i(0)) && all(texel <= last);
    return select(vec2f(0.0), ambient_at(clamp(texel, vec2i(0), last)), is_inside);
}

// Returns the weighted visibility and the weight of a tap at this squared distance in texels; (0, 0) if there
// is no surface.
fn tap(squared: f32, z: f32, other: vec2f, run: vec2f) -> vec2f {
    let d = (other.y * (1.0 + run.x) - (z + run.y)) * blur.inverse_depth_width;
    return select(0.0, exp(-d * d - squared * blur.inverse_distance_width), other.y > 0.0) * vec2f(other.x, 1.0);
}

// Returns the absolute difference between a tap's visibility and the centre's. Outside the picture, the last
// texel is used.
fn difference(texel: vec2i, visibility: f32) -> f32 {
    return abs(ambient_at(clamp(texel, vec2i(0), vec2i(blur.size) - 1)).x - visibility);
}

// The edge test: there is nothing to smooth if the tips of the line and the midpoints of its halves have the
// centre's visibility.
fn is_even_line(texel: vec2i, axis: vec2i, visibility: f32) -> bool {
    let tip = i32(blur.taps_per_side) * axis;
    let middle = (i32(blur.taps_per_side) + 1) / 2 * axis;
    let tips = max(difference(texel - tip, visibility), difference(texel + tip, visibility));
    let middles = max(difference(texel - middle, visibility), difference(texel + middle, visibility));
    return max(tips, middles) <= blur.edge_tolerance;
}

// The edge test for the square: tips along the axes, midpoints along the diagonals.
fn is_even_square(texel: vec2i, visibility: f32) -> bool {
    let tip = i32(blur.taps_per_side);
    let m = (tip + 1) / 2;
    let x = max(difference(texel - vec2i(tip, 0), visibility), difference(texel + vec2i(tip, 0), visibility));
    let y = max(difference(texel - vec2i(0, tip), visibility), difference(texel + vec2i(0, tip), visibility));
    let down = max(difference(texel - vec2i(m, m), visibility), difference(texel + vec2i(m, m), visibility));
    let up = max(difference(texel - vec2i(m, -m), visibility), difference(texel + vec2i(m, -m), visibility));
    return max(max(x, y), max(down, up)) <= blur.edge_tolerance;
}

// Returns the range of taps of a line that are inside the picture.
fn reach(at: i32, size: u32) -> vec2i {
    let side = i32(blur.taps_per_side);
    return vec2i(max(-side, -at), min(side, i32(size) - 1 - at));
}

// Returns the bilateral mean along a line through a texel that has a surface.
fn bilateral_of_line(texel: vec2i, center: vec2f, axis: vec2i) -> f32 {
    let z = center.y;
    let before = ambient_near(texel - axis);
    let after = ambient_near(texel + axis);
    let run = adumbra_occlusion_run(before.y, z, after.y, blur.plane_kind, blur.inverse_depth_width);
    var sum = vec2f(center.x, 1.0) + tap(1.0, z, before, -run) + tap(1.0, z, after, run);
    for (var i = 2; i <= i32(blur.taps_per_side); i++) {
        let squared = f32(i * i);
        sum += tap(squared, z, ambient_near(texel - i * axis), -f32(i) * run);
        sum += tap(squared, z, ambient_near(texel + i * axis), f32(i) * run);
    }
    return sum.x / sum.y;
}

fn bilateral_of_square(texel: vec2i, z: f32) -> f32 {
    let left = ambient_near(texel - vec2i(1, 0)).y;
    let right = ambient_near(texel + vec2i(1, 0)).y;
    let above = ambient_near(texel - vec2i(0, 1)).y;
    let below = ambient_near(texel + vec2i(0, 1)).y;
    let run_x = adumbra_occlusion_run(left, z, right, blur.plane_kind, blur.inverse_depth_width);
    let run_y = adumbra_occlusion_run(above, z, below, blur.plane_kind, blur.inverse_depth_width);
    let columns = reach(texel.x, blur.size.x);
    let rows = reach(texel.y, blur.size.y);
    var sum = vec2f(0.0);
    for (var j = rows.x; j <= rows.y; j++) {
        for (var i = columns.x; i <= columns.y; i++) {
            let run = f32(i) * run_x + f32(j) * run_y;
            sum += tap(f32(i * i + j * j), z, ambient_at(texel + vec2i(i, j)), run);
        }
    }
    return sum.x / sum.y;
}

// For comparison: a Gaussian that takes into account whether there is a surface, but not its depth.
fn gauss_of_line(texel: vec2i, center: vec2f, axis: vec2i) -> f32 {
    var sum = vec2f(center.x, 1.0);
    for (var i = 1; i <= i32(blur.taps_per_side); i++) {
        let near = exp(-f32(i * i) * blur.inverse_distance_width);
        let before = ambient_near(texel - i * axis);
        let after = ambient_near(texel + i * axis);
        sum += select(0.0, near, before.y > 0.0) * vec2f(before.x, 1.0);
        sum += select(0.0, near, after.y > 0.0) * vec2f(after.x, 1.0);
    }
    return sum.x / sum.y;
}

const BILATERAL_LINE: u32 = 0u;
const BILATERAL_SQUARE: u32 = 1u;
const GAUSS_LINE: u32 = 2u;

fn smooth_texel(id: vec2u, kind: u32) {
    if (any(id >= blur.size)) {
        return;
    }
    let texel = vec2i(id);
    let center = ambient_at(texel);
    let axis = select(vec2i(1, 0), vec2i(0, 1), blur.axis == 1u);
    var is_even = false;
    if (center.y > 0.0 && blur.edge_tolerance >= 0.0) {
        if (kind == BILATERAL_SQUARE) {
            is_even = is_even_square(texel, center.x);
        } else {
            is_even = is_even_line(texel, axis, center.x);
        }
    }
    var visibility = center.x;
    if (center.y > 0.0 && !is_even) {
        switch kind {
            case BILATERAL_LINE: {
                visibility = bilateral_of_line(texel, center, axis);
            }
            case BILATERAL_SQUARE: {
                visibility = bilateral_of_square(texel, center.y);
            }
            default: {
                visibility = gauss_of_line(texel, center, axis);
            }
        }
    }
    textureStore(ambient_out, id, vec4f(visibility, center.y, 0.0, 0.0));
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn bilateral_line(@builtin(global_invocation_id) id: vec3u) {
    smooth_texel(id.xy, BILATERAL_LINE);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn bilateral_square(@builtin(global_invocation_id) id: vec3u) {
    smooth_texel(id.xy, BILATERAL_SQUARE);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn gauss_line(@builtin(global_invocation_id) id: vec3u) {
    smooth_texel(id.xy, GAUSS_LINE);
}
