// Edge-aware blur guided by depth and normal: only texels on the pixel's own surface count, so that no shadow
// crosses a silhouette. One thread per texel. Texel q has the surface of the frame's pixel q ·
// pixels_per_texel. Sky pixels keep their factor of 1 and never count for others.

struct Center {
    surface: AdumbraSurface,
    tolerance_world: f32,
    sky: bool,
}

fn center_at(texel: vec2u) -> Center {
    let pixel = texel * blur.pixels_per_texel;
    let depth = textureLoad(gbuffer_depth, pixel, 0);
    var c: Center;
    c.sky = depth == 0.0;
    if (!c.sky) {
        c.surface = surface_at(pixel, depth);
        c.tolerance_world = blur.tolerance_pixels * adumbra_blur_pixel_world(frame, c.surface.view_depth);
    }
    return c;
}

// Returns the weight of a texel's factor for the centre, without the Gaussian; 0 beyond the border.
fn share(c: Center, texel: vec2i) -> f32 {
    if (any(texel < vec2i(0)) || any(texel >= vec2i(blur.size))) {
        return 0.0;
    }
    let pixel = vec2u(texel) * blur.pixels_per_texel;
    let depth = textureLoad(gbuffer_depth, pixel, 0);
    if (depth == 0.0) {
        return 0.0;
    }
    return adumbra_blur_same_surface(c.surface, surface_at(pixel, depth), c.tolerance_world);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn blur_line_edges(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size)) {
        return;
    }
    let c = center_at(id.xy);
    var sum = blur.taps[0].weight * textureLoad(factor_in, id.xy, 0).x;
    var weights = blur.taps[0].weight;
    if (!c.sky) {
        let side = i32(blur.taps_per_side);
        for (var i = -side; i <= side; i++) {
            let texel = vec2i(id.xy) + along(i);
            let weight = select(blur.taps[abs(i)].weight * share(c, texel), 0.0, i == 0);
            if (weight > 0.0) {
                sum += weight * textureLoad(factor_in, texel, 0).x;
                weights += weight;
            }
        }
    }
    write_factor(id.xy, sum / weights);
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn blur_square_edges(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= blur.size)) {
        return;
    }
    let c = center_at(id.xy);
    let own = blur.taps[0].weight * blur.taps[0].weight;
    var sum = own * textureLoad(factor_in, id.xy, 0).x;
    var weights = own;
    if (!c.sky) {
        let side = i32(blur.taps_per_side);
        for (var y = -side; y <= side; y++) {
            for (var x = -side; x <= side; x++) {
                let texel = vec2i(id.xy) + vec2i(x, y);
                let gauss = blur.taps[abs(x)].weight * blur.taps[abs(y)].weight;
                let weight = select(gauss * share(c, texel), 0.0, x == 0 && y == 0);
                if (weight > 0.0) {
                    sum += weight * textureLoad(factor_in, texel, 0).x;
                    weights += weight;
                }
            }
        }
    }
    write_factor(id.xy, sum / weights);
}
