// The blur that sees depth and normal: only texels on the pixel's own surface count, so that no shade crosses a silhouette. One thread a
// texel. Texel q stands for the picture's pixel q · counts.y. Sky is 1 and never counts for others.

@group(0) @binding(0) var<uniform> blur: BlurParams;
@group(0) @binding(1) var factor_in: texture_2d<f32>;
@group(0) @binding(2) var factor_out: texture_storage_2d<r32float, write>;
@group(0) @binding(3) var<uniform> frame: Frame;
@group(0) @binding(4) var gbuffer_depth: texture_depth_2d;
@group(0) @binding(5) var gbuffer_normal: texture_2d<f32>;

struct Center {
    surface: Surface,
    tolerance_world: f32,
    sky: bool,
}

fn surface_at(texel: vec2u, depth: f32) -> Surface {
    let pixel = texel * blur.counts.y;
    return frame_surface(frame, pixel, depth, textureLoad(gbuffer_normal, pixel, 0).xyz);
}

fn center_at(texel: vec2u) -> Center {
    let depth = textureLoad(gbuffer_depth, texel * blur.counts.y, 0);
    var c: Center;
    c.sky = depth == 0.0;
    if (!c.sky) {
        c.surface = surface_at(texel, depth);
        c.tolerance_world = blur.shape.y * blur_pixel_world(frame, c.surface.view_depth);
    }
    return c;
}

// Weight of a texel's factor for the center, without the Gaussian; 0 beyond the border.
fn share(c: Center, texel: vec2i) -> f32 {
    if (any(texel < vec2i(0)) || any(texel >= vec2i(blur.size.xy))) {
        return 0.0;
    }
    let depth = textureLoad(gbuffer_depth, vec2u(texel) * blur.counts.y, 0);
    if (depth == 0.0) {
        return 0.0;
    }
    return blur_same_surface(c.surface, surface_at(vec2u(texel), depth), c.tolerance_world);
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn blur_line_edges(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let c = center_at(id.xy);
    var sum = blur.taps[0].x * textureLoad(factor_in, id.xy, 0).x;
    var weights = blur.taps[0].x;
    if (!c.sky) {
        let side = i32(blur.counts.x);
        for (var i = -side; i <= side; i++) {
            let texel = vec2i(id.xy) + select(vec2i(i, 0), vec2i(0, i), blur.counts.z == 1u);
            let weight = select(blur.taps[abs(i)].x * share(c, texel), 0.0, i == 0);
            if (weight > 0.0) {
                sum += weight * textureLoad(factor_in, texel, 0).x;
                weights += weight;
            }
        }
    }
    textureStore(factor_out, id.xy, vec4f(sum / weights, 0.0, 0.0, 0.0));
}

@compute @workgroup_size(PIXEL_GROUP, PIXEL_GROUP)
fn blur_square_edges(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size.xy)) {
        return;
    }
    let c = center_at(id.xy);
    let own = blur.taps[0].x * blur.taps[0].x;
    var sum = own * textureLoad(factor_in, id.xy, 0).x;
    var weights = own;
    if (!c.sky) {
        let side = i32(blur.counts.x);
        for (var y = -side; y <= side; y++) {
            for (var x = -side; x <= side; x++) {
                let texel = vec2i(id.xy) + vec2i(x, y);
                let gauss = blur.taps[abs(x)].x * blur.taps[abs(y)].x;
                let weight = select(gauss * share(c, texel), 0.0, x == 0 && y == 0);
                if (weight > 0.0) {
                    sum += weight * textureLoad(factor_in, texel, 0).x;
                    weights += weight;
                }
            }
        }
    }
    textureStore(factor_out, id.xy, vec4f(sum / weights, 0.0, 0.0, 0.0));
}
