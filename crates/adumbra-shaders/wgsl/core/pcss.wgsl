// Soft shadows whose width follows the distance of what casts them.
// Source: Fernando, Percentage-Closer Soft Shadows, 2005.
// Departure: for a sun, whose rays from one point fill a cone of fixed angle, a caster at a distance d along the light is a blocker
// within tan(angle / 2) · d of the point, and its penumbra is 2 · tan(angle / 2) · d wide. Only casters within their own cone count; taps
// of the search are denser towards the middle, where near casters must be found.

// Mean distance from the receiver to its blockers in depth units; negative where there are none.
// `cone_texels`: radius of the sun's cone in texels for a distance of one depth unit. `max_radius`: searched at most, texels.
fn pcss_blocker_distance(
    map: texture_depth_2d_array,
    r: MapReceiver,
    cone_texels: f32,
    max_radius: f32,
    turn: vec2f,
) -> f32 {
    let last = vec2i(textureDimensions(map)) - 1;
    // No caster is nearer the sun than depth 0. At least the receiver's own texel and its neighbours.
    let search = clamp(cone_texels * r.depth, 1.0, max_radius);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < 32u; i++) {
        let tap = disc_tap(i, turn);
        // As many taps on every ring of equal width.
        let offset = search * length(tap) * tap;
        let texel = clamp(vec2i(floor(r.p_texels + offset)), vec2i(0), last);
        let stored = textureLoad(map, texel, r.layer, 0);
        let distance = r.depth - stored;
        let in_cone = length(offset) <= max(cone_texels * distance, 1.0);
        if (in_cone && map_plane_depth(r, vec2f(texel) + 0.5) > stored) {
            sum += max(distance, 0.0);
            count += 1.0;
        }
    }
    return select(-1.0, sum / max(count, 1.0), count > 0.0);
}

fn pcss_visibility(
    map: texture_depth_2d_array,
    gathering: sampler,
    r: MapReceiver,
    cone_texels: f32,
    max_radius: f32,
    turn: vec2f,
) -> f32 {
    let distance = pcss_blocker_distance(map, r, cone_texels, max_radius, turn);
    if (distance < 0.0) {
        return 1.0;
    }
    // Bilinear taps are a texel wide themselves.
    let radius = clamp(cone_texels * distance, 0.5, max_radius);
    return pcf_disc(map, gathering, r, radius, 32u, turn);
}
