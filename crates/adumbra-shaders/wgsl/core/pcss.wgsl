// Soft shadows whose penumbra width follows the distance of the caster. Source: Fernando, Percentage-Closer
// Soft Shadows, 2005. Departure: the rays from one point to the sun fill a cone of fixed angle. A caster at
// distance d along the light is a blocker if it is within tan(angle / 2) · d of the point, and its penumbra
// is 2 · tan(angle / 2) · d wide. A caster counts only within the cone's radius at its own distance. The taps
// of the search are denser towards the centre, where near casters must be found.

// Returns the mean distance from the receiver to its blockers in depth units; negative if there are none.
// `cone_texels` is the radius of the sun's cone in texels at a distance of one depth unit. `max_radius`
// limits the search, in texels.
fn adumbra_pcss_blocker_distance(
    map: texture_depth_2d_array,
    r: AdumbraMapReceiver,
    cone_texels: f32,
    max_radius: f32,
    turn: vec2f,
) -> f32 {
    let last = vec2i(textureDimensions(map)) - 1;
    // No caster is nearer to the sun than depth 0. The search covers at least the receiver's own texel and
    // its neighbours.
    let search = clamp(cone_texels * r.depth, 1.0, max_radius);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < 32u; i++) {
        let tap = adumbra_disc_tap(i, turn);
        // Gives all rings of equal width the same number of taps.
        let offset = search * length(tap) * tap;
        let texel = clamp(vec2i(floor(r.p_texels + offset)), vec2i(0), last);
        let stored = textureLoad(map, texel, r.layer, 0);
        let distance = r.depth - stored;
        let in_cone = length(offset) <= max(cone_texels * distance, 1.0);
        if (in_cone && adumbra_map_plane_depth(r, vec2f(texel) + 0.5) > stored) {
            sum += max(distance, 0.0);
            count += 1.0;
        }
    }
    return select(-1.0, sum / max(count, 1.0), count > 0.0);
}

fn adumbra_pcss_visibility(
    map: texture_depth_2d_array,
    gathering: sampler,
    r: AdumbraMapReceiver,
    cone_texels: f32,
    max_radius: f32,
    turn: vec2f,
) -> f32 {
    let distance = adumbra_pcss_blocker_distance(map, r, cone_texels, max_radius, turn);
    if (distance < 0.0) {
        return 1.0;
    }
    // The footprint of a bilinear tap is itself one texel wide.
    let radius = clamp(cone_texels * distance, 0.5, max_radius);
    return adumbra_pcf_disc(map, gathering, r, radius, 32u, turn);
}
