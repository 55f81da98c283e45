// Filters of ambient visibility. Bilateral (Qiu et al. 2014, equation 7): weights fall with the distance of texels and with
// the difference of their view depths, exp(-(difference / sigma)² / 2) each. Departures: two lines may stand for the
// square; the difference may be taken from the centre's own surface (occlusion_run). Visibility and view depth come from
// one texture. Sky counts nowhere and stays as it is. One thread a texel.

@group(0) @binding(0) var<uniform> blur: OcclusionFilterParams;
@group(0) @binding(1) var ambient_in: texture_2d<f32>;
@group(0) @binding(2) var ambient_out: texture_storage_2d<rg32float, write>;

fn ambient_at(texel: vec2i) -> vec2f {
    return textureLoad(ambient_in, texel, 0).xy;
}

// 0, 0 beyond the picture.
fn ambient_near(texel: vec2i) -> vec2f {
    let last = vec2i(blur.counts.xy) - 1;
    let is_inside = all(texel >= vec2i(0)) && all(texel <= last);
    return select(vec2f(0.0), ambient_at(clamp(texel, vec2i(0), last)), is_inside);
}

// Weighted visibility and weight of a tap whose distance has this square, in texels; 0, 0 for what is not there.
fn tap(squared: f32, z: f32, other: vec2f, run: vec2f) -> vec2f {
    let d = (other.y * (1.0 + run.x) - (z + run.y)) * blur.shape.x;
    return select(0.0, exp(-d * d - squared * blur.near.x), other.y > 0.0) * vec2f(other.x, 1.0);
}

// How far the visibility of a tap, or of the picture's last texel before it, is from the centre's.
fn difference(texel: vec2i, visibility: f32) -> f32 {
    return abs(ambient_at(clamp(texel, vec2i(0), vec2i(blur.counts.xy) - 1)).x - visibility);
}

// The edge test: nothing to smooth where the tips of the line and their middles have the centre's visibility.
fn is_even_line(texel: vec2i, axis: vec2i, visibility: f32) -> bool {
    let tip = i32(blur.counts.z) * axis;
    let middle = (i32(blur.counts.z) + 1) / 2 * axis;
    let tips = max(difference(texel - tip, visibility), difference(texel + tip, visibility));
    let middles = max(difference(texel - middle, visibility), difference(texel + middle, visibility));
    return max(tips, middles) <= blur.shape.w;
}

// The same of the square: tips along the axes, middles along the diagonals.
fn is_even_square(texel: vec2i, visibility: f32) -> bool {
    let tip = i32(blur.counts.z);
    let m = (tip + 1) / 2;
    let x = max(difference(texel - vec2i(tip, 0), visibility), difference(texel + vec2i(tip, 0), visibility));
    let y = max(difference(texel - vec2i(0, tip), visibility), difference(texel + vec2i(0, tip), visibility));
    let down = max(difference(texel - vec2i(m, m), visibility), difference(texel + vec2i(m, m), visibility));
    let up = max(difference(texel - vec2i(m, -m), visibility), difference(texel + vec2i(m, -m), visibility));
    return max(max(x, y), max(down, up)) <= blur.shape.w;
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
        let z = center.y;
        let before = ambient_near(texel - axis);
        let after = ambient_near(texel + axis);
        let run = occlusion_run(before.y, z, after.y, blur.shape.yz, blur.shape.x);
        var sum = vec2f(center.x, 1.0) + tap(1.0, z, before, -run) + tap(1.0, z, after, run);
        for (var i = 2; i <= i32(blur.counts.z); i++) {
            let squared = f32(i * i);
            sum += tap(squared, z, ambient_near(texel - i * axis), -f32(i) * run);
            sum += tap(squared, z, ambient_near(texel + i * axis), f32(i) * run);
        }
        visibility = sum.x / sum.y;
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
        let z = center.y;
        let left = ambient_near(texel - vec2i(1, 0)).y;
        let right = ambient_near(texel + vec2i(1, 0)).y;
        let above = ambient_near(texel - vec2i(0, 1)).y;
        let below = ambient_near(texel + vec2i(0, 1)).y;
        let run_x = occlusion_run(left, z, right, blur.shape.yz, blur.shape.x);
        let run_y = occlusion_run(above, z, below, blur.shape.yz, blur.shape.x);
        let columns = reach(texel.x, blur.counts.x);
        let rows = reach(texel.y, blur.counts.y);
        var sum = vec2f(0.0);
        for (var j = rows.x; j <= rows.y; j++) {
            for (var i = columns.x; i <= columns.y; i++) {
                let run = f32(i) * run_x + f32(j) * run_y;
                sum += tap(f32(i * i + j * j), z, ambient_at(texel + vec2i(i, j)), run);
            }
        }
        visibility = sum.x / sum.y;
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
        var sum = vec2f(center.x, 1.0);
        for (var i = 1; i <= i32(blur.counts.z); i++) {
            let near = exp(-f32(i * i) * blur.near.x);
            let before = ambient_near(texel - i * axis);
            let after = ambient_near(texel + i * axis);
            sum += select(0.0, near, before.y > 0.0) * vec2f(before.x, 1.0);
            sum += select(0.0, near, after.y > 0.0) * vec2f(after.x, 1.0);
        }
        visibility = sum.x / sum.y;
    }
    textureStore(ambient_out, id.xy, vec4f(visibility, center.y, 0.0, 0.0));
}
