// The bilateral filter of ambient visibility (Qiu et al. 2014, equation 7): weights fall with the distance of texels and with the difference
// of their view depths, exp(-(difference / sigma)² / 2) each. Visibility and view depth come from one texture. One thread a texel.

@group(0) @binding(0) var<uniform> blur: OcclusionFilterParams;
@group(0) @binding(1) var ambient_in: texture_2d<f32>;
@group(0) @binding(2) var ambient_out: texture_storage_2d<rg32float, write>;

fn is_inside(texel: vec2i) -> bool {
    return all(texel >= vec2i(0)) && all(texel < vec2i(blur.counts.xy));
}

fn near_weight(distance: i32) -> f32 {
    let i = u32(abs(distance));
    return blur.weights[i >> 2u][i & 3u];
}

// 0 for what is not there.
fn depth_weight(z: f32, other_z: f32) -> f32 {
    let d = (other_z - z) / blur.shape.y;
    return select(0.0, exp(-0.5 * d * d), other_z > 0.0);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn bilateral_line(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.counts.xy)) {
        return;
    }
    let center = textureLoad(ambient_in, id.xy, 0).xy;
    var sum = center.x;
    var weights = 1.0;
    if (center.y > 0.0) {
        let side = i32(blur.counts.z);
        for (var i = -side; i <= side; i++) {
            let texel = vec2i(id.xy) + select(vec2i(i, 0), vec2i(0, i), blur.counts.w == 1u);
            if (i == 0 || !is_inside(texel)) {
                continue;
            }
            let other = textureLoad(ambient_in, texel, 0).xy;
            let weight = near_weight(i) * depth_weight(center.y, other.y);
            sum += weight * other.x;
            weights += weight;
        }
    }
    textureStore(ambient_out, id.xy, vec4f(sum / weights, center.y, 0.0, 0.0));
}
