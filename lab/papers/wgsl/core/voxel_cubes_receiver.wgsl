// Converts a surface to a receiver in a tree: its bias, the level of its cells, and for a point outside the
// cube the entry point of its sun ray. This is the counterpart of
// adumbra_papers::tree::query::TreeQuery::receiver. The pass provides the regions through these accessors:
//     fn adumbra_cubes_plan_edges(axis: u32, index: u32) -> vec4i     four edges along x (0) or z (1)
//     fn adumbra_cubes_plan_levels(index: u32) -> vec4u               32 levels, four bits each
//     fn adumbra_cubes_plan_counts() -> vec2u                         edges along x, along z

struct AdumbraCubesPlace {
    receiver: AdumbraCubesReceiver,
    // False if the point is lit because its sun ray misses the cube.
    found: bool,
}

// Returns the number of edges at or before a position.
fn adumbra_cubes_column(axis: u32, count: u32, p_fixed: i32) -> u32 {
    var column = 0u;
    for (var i = 0u; i < count; i += 4u) {
        let before = vec4i(p_fixed >> ADUMBRA_FIXED_BITS) >= adumbra_cubes_plan_edges(axis, i >> 2u);
        let there = vec4u(i, i + 1u, i + 2u, i + 3u) < vec4u(count);
        column += dot(vec4u(before & there), vec4u(1u));
    }
    return column;
}

// Returns the level of the coarsest cells in the plan rectangle between two corners.
fn adumbra_cubes_coarsest(low: vec2i, high: vec2i) -> u32 {
    let counts = adumbra_cubes_plan_counts();
    let x = vec2u(adumbra_cubes_column(0u, counts.x, low.x), adumbra_cubes_column(0u, counts.x, high.x));
    let z = vec2u(adumbra_cubes_column(1u, counts.y, low.y), adumbra_cubes_column(1u, counts.y, high.y));
    var coarsest = 0u;
    for (var row = z.x; row <= z.y; row++) {
        for (var column = x.x; column <= x.y; column++) {
            let at = row * (counts.x + 1u) + column;
            let words = adumbra_cubes_plan_levels(at >> 5u);
            let pair = select(words.xy, words.zw, (at & 16u) != 0u);
            let word = select(pair.x, pair.y, (at & 8u) != 0u);
            coarsest = max(coarsest, (word >> (4u * (at & 7u))) & 15u);
        }
    }
    return coarsest;
}

// Returns the level of the coarsest cells around a point and its lifted position, within the kernel's reach.
// `lift` is in cells.
fn adumbra_cubes_level(c: AdumbraCubesParams, g: AdumbraGridPosition, lift: vec3f) -> u32 {
    if (all(adumbra_cubes_plan_counts() == vec2u(0u))) {
        return c.base_level;
    }
    let p = adumbra_grid_fixed(c.grid, g, vec3f(0.0)).xz;
    var level = adumbra_cubes_coarsest(p, p);
    loop {
        let size = f32(1u << level);
        // Beyond the margin the exact distance does not matter, and a larger one would overflow 32 bits.
        let limit = f32(ADUMBRA_MARGIN_VOXELS) + f32(c.grid.size.x);
        let lifted = adumbra_grid_fixed(c.grid, g, clamp(lift * size, vec3f(-limit), vec3f(limit))).xz;
        let margin = min((i32(c.reach) + 1) << level, c.grid.size.x) * ADUMBRA_FIXED_ONE;
        let coarsest = adumbra_cubes_coarsest(min(p, lifted) - margin, max(p, lifted) + margin);
        if (coarsest <= level) {
            return level;
        }
        level = coarsest;
    }
    // Unreachable; some compilers require a return here.
    return level;
}

// Returns the first point inside the cube on the ray from p, in voxels, towards the sun; w = 0 if the ray
// misses the cube.
fn adumbra_cubes_entry(c: AdumbraCubesParams, p: vec3f) -> vec4f {
    let side = f32(c.grid.size.x);
    let d = c.towards_sun;
    // A ray parallel to a pair of faces never crosses them: it is between them or misses the cube.
    let along_face = d == vec3f(0.0);
    if (any(along_face & ((p < vec3f(0.0)) | (p >= vec3f(side))))) {
        return vec4f(0.0);
    }
    let inverse = 1.0 / select(d, vec3f(1.0), along_face);
    let a = -p * inverse;
    let b = (side - p) * inverse;
    let near = select(min(a, b), vec3f(0.0), along_face);
    let far = select(max(a, b), vec3f(3.0e38), along_face);
    let enter = max(max(near.x, near.y), max(near.z, 0.0));
    let leave = min(far.x, min(far.y, far.z));
    if (!(enter < leave)) {
        return vec4f(0.0);
    }
    return vec4f(p + d * enter, 1.0);
}

fn adumbra_cubes_place(c: AdumbraCubesParams, s: AdumbraSurface) -> AdumbraCubesPlace {
    let towards_sun = c.towards_sun;
    let n_dot_l = dot(s.normal, towards_sun);
    let tangent = length(s.normal - n_dot_l * towards_sun);
    var slope = 0.0;
    if (tangent > 0.0) {
        slope = min(tangent / max(n_dot_l, tangent / ADUMBRA_MAX_SLOPE), ADUMBRA_MAX_SLOPE);
    }
    let lift = towards_sun * adumbra_bias_along_light(c.bias, slope) + s.normal * c.bias.normal_offset_texels;
    let g = adumbra_grid_position(c.grid, s.p_relative);
    let level = adumbra_cubes_level(c, g, lift);
    let size = f32(1u << level);
    let end = c.grid.size.x * ADUMBRA_FIXED_ONE;

    var place: AdumbraCubesPlace;
    place.found = true;
    place.receiver.level = level;
    var moved = lift * size;
    place.receiver.p_fixed = adumbra_grid_fixed(c.grid, g, moved);
    if (any(place.receiver.p_fixed < vec3i(0)) || any(place.receiver.p_fixed >= vec3i(end))) {
        let entry = adumbra_cubes_entry(c, g.voxels + moved);
        place.found = entry.w > 0.0;
        moved = entry.xyz - g.voxels;
        place.receiver.p_fixed = vec3i(floor(entry.xyz * f32(ADUMBRA_FIXED_ONE)));
    }
    place.receiver.p_fixed = clamp(place.receiver.p_fixed, vec3i(0), vec3i(end - 1));
    if (c.counts_all_taps == 0u) {
        let height = dot(s.normal, moved) / size * f32(ADUMBRA_NORMAL_ONE) + 0.5;
        let limit = ADUMBRA_MAX_HEIGHT_CELLS * ADUMBRA_NORMAL_ONE;
        place.receiver.normal = vec3i(floor(s.normal * f32(ADUMBRA_NORMAL_ONE) + 0.5));
        place.receiver.height = clamp(i32(floor(height)), -limit, limit);
    }
    return place;
}

fn adumbra_cubes_factor(c: AdumbraCubesParams, s: AdumbraSurface) -> f32 {
    let place = adumbra_cubes_place(c, s);
    if (!place.found) {
        return 1.0;
    }
    let sum = adumbra_cubes_lit_weights(c, place.receiver);
    return f32(sum.x) / f32(sum.y);
}
