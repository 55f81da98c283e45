// Filters of ambient visibility. Bilateral (Qiu et al. 2014, equation 7): weights fall with the distance of texels and with the difference of
// their view depths, exp(-(difference / sigma)² / 2) each. Departures: two lines may stand for the square; the difference may be taken from the
// centre's own surface (occlusion_run). Visibility and view depth come from one texture. Sky counts nowhere and stays as it is. One thread a
// texel.

@group(0) @binding(0) var<uniform> blur: OcclusionFilterParams;
@group(0) @binding(1) var ambient_in: texture_2d<f32>;
@group(0) @binding(2) var ambient_out: texture_storage_2d<rg32float, write>;

fn ambient_at(texel: vec2i) -> vec2f {
    return textureLoad(ambient_in, texel, 0).xy;
}

// Of a tap whose distance has this square, in texels; 0 for what is not there.
fn weight_of(squared: f32, z: f32, other_z: f32, run: vec2f) -> f32 {
    let d = (other_z * (1.0 + run.x) - (z + run.y)) * blur.shape.x;
    return select(0.0, exp(-d * d - squared * blur.near.x), other_z > 0.0);
}

// View depth, 0 beyond the picture.
fn depth_at(texel: vec2i) -> f32 {
    let last = vec2i(blur.counts.xy) - 1;
    return select(0.0, ambient_at(clamp(texel, vec2i(0), last)).y, all(texel >= vec2i(0)) && all(texel <= last));
}

fn run_along(texel: vec2i, axis: vec2i, z: f32) -> vec2f {
    return occlusion_run(depth_at(texel - axis), z, depth_at(texel + axis), blur.shape.yz, blur.shape.x);
}

// Whether a tap, or the picture's last texel before it, has about the centre's visibility.
fn agrees(texel: vec2i, visibility: f32) -> bool {
    let other = ambient_at(clamp(texel, vec2i(0), vec2i(blur.counts.xy) - 1)).x;
    return abs(other - visibility) <= blur.shape.w;
}

// The edge test: nothing to smooth where the tips of the line and their middles have the centre's visibility.
fn is_even_line(texel: vec2i, axis: vec2i, visibility: f32) -> bool {
    let tip = i32(blur.counts.z) * axis;
    let middle = (i32(blur.counts.z) + 1) / 2 * axis;
    return agrees(texel - tip, visibility) && agrees(texel + tip, visibility)
        && agrees(texel - middle, visibility) && agrees(texel + middle, visibility);
}

// The same of the square: tips along the axes, middles along the diagonals.
fn is_even_square(texel: vec2i, visibility: f32) -> bool {
    let tip = i32(blur.counts.z);
    let m = (tip + 1) / 2;
    return agrees(texel - vec2i(tip, 0), visibility) && agrees(texel + vec2i(tip, 0), visibility)
        && agrees(texel - vec2i(0, tip), visibility) && agrees(texel + vec2i(0, tip), visibility)
        && agrees(texel - vec2i(m, m), visibility) && agrees(texel + vec2i(m, m), visibility)
        && agrees(texel - vec2i(m, -m), visibility) && agrees(texel + vec2i(m, -m), visibility);
}

// The taps of a line that are in the picture.
fn reach(at: i32, size: u32) -> vec2i {
    let side = i32(blur.counts.z);
    return vec2i(max(-side, -at), min(side, i32(size) - 1 - at));
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn bilateral_line(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.counts.xy)) {
        return;
    }
    let texel = vec2i(id.xy);
    let center = ambient_at(texel);
    let axis = select(vec2i(1, 0), vec2i(0, 1), blur.counts.w == 1u);
    var visibility = center.x;
    if (center.y > 0.0 && !(blur.shape.w >= 0.0 && is_even_line(texel, axis, center.x))) {
        let run = run_along(texel, axis, center.y);
        let taps = reach(dot(texel, axis), blur.counts[blur.counts.w]);
        var sum = 0.0;
        var weights = 0.0;
        for (var i = taps.x; i <= taps.y; i++) {
            let other = ambient_at(texel + i * axis);
            let weight = weight_of(f32(i * i), center.y, other.y, f32(i) * run);
            sum += weight * other.x;
            weights += weight;
        }
        visibility = sum / weights;
    }
    textureStore(ambient_out, id.xy, vec4f(visibility, center.y, 0.0, 0.0));
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn bilateral_square(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.counts.xy)) {
        return;
    }
    let texel = vec2i(id.xy);
    let center = ambient_at(texel);
    var visibility = center.x;
    if (center.y > 0.0 && !(blur.shape.w >= 0.0 && is_even_square(texel, center.x))) {
        let run_x = run_along(texel, vec2i(1, 0), center.y);
        let run_y = run_along(texel, vec2i(0, 1), center.y);
        let columns = reach(texel.x, blur.counts.x);
        let rows = reach(texel.y, blur.counts.y);
        var sum = 0.0;
        var weights = 0.0;
        for (var j = rows.x; j <= rows.y; j++) {
            for (var i = columns.x; i <= columns.y; i++) {
                let other = ambient_at(texel + vec2i(i, j));
                let run = f32(i) * run_x + f32(j) * run_y;
                let weight = weight_of(f32(i * i + j * j), center.y, other.y, run);
                sum += weight * other.x;
                weights += weight;
            }
        }
        visibility = sum / weights;
    }
    textureStore(ambient_out, id.xy, vec4f(visibility, center.y, 0.0, 0.0));
}

// To compare with: sees that there is something, not how far.
@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn gauss_line(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.counts.xy)) {
        return;
    }
    let texel = vec2i(id.xy);
    let center = ambient_at(texel);
    let axis = select(vec2i(1, 0), vec2i(0, 1), blur.counts.w == 1u);
    var visibility = center.x;
    if (center.y > 0.0 && !(blur.shape.w >= 0.0 && is_even_line(texel, axis, center.x))) {
        let taps = reach(dot(texel, axis), blur.counts[blur.counts.w]);
        var sum = 0.0;
        var weights = 0.0;
        for (var i = taps.x; i <= taps.y; i++) {
            let other = ambient_at(texel + i * axis);
            let weight = select(0.0, exp(-f32(i * i) * blur.near.x), other.y > 0.0);
            sum += weight * other.x;
            weights += weight;
        }
        visibility = sum / weights;
    }
    textureStore(ambient_out, id.xy, vec4f(visibility, center.y, 0.0, 0.0));
}
