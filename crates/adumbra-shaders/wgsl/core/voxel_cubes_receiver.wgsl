// From a surface to what answers it in a tree: bias, the level of the cells, and the place where the sun ray of a point outside the
// cube enters it. The twin of adumbra::query::TreeQuery::receiver. The regions come through two accessors of the pass:
//     fn cubes_plan_edges(axis: u32, index: u32) -> vec4i     four edges along x (0) or z (1)
//     fn cubes_plan_levels(index: u32) -> vec4u               32 levels, four bits each
//     fn cubes_plan_counts() -> vec2u                         edges along x, along z

struct CubesPlace {
    receiver: CubesReceiver,
    // False where the point is lit because its sun ray misses the cube.
    found: bool,
}

// How many edges lie at or before a position.
fn cubes_column(axis: u32, count: u32, p_fixed: i32) -> u32 {
    var column = 0u;
    for (var i = 0u; i < count; i += 4u) {
        let before = vec4i(p_fixed >> FIXED_BITS) >= cubes_plan_edges(axis, i >> 2u);
        let there = vec4u(i, i + 1u, i + 2u, i + 3u) < vec4u(count);
        column += dot(vec4u(before & there), vec4u(1u));
    }
    return column;
}

// Level of the coarsest cells between two corners of the plan.
fn cubes_coarsest(low: vec2i, high: vec2i) -> u32 {
    let counts = cubes_plan_counts();
    let x = vec2u(cubes_column(0u, counts.x, low.x), cubes_column(0u, counts.x, high.x));
    let z = vec2u(cubes_column(1u, counts.y, low.y), cubes_column(1u, counts.y, high.y));
    var coarsest = 0u;
    for (var row = z.x; row <= z.y; row++) {
        for (var column = x.x; column <= x.y; column++) {
            let at = row * (counts.x + 1u) + column;
            let words = cubes_plan_levels(at >> 5u);
            let pair = select(words.xy, words.zw, (at & 16u) != 0u);
            let word = select(pair.x, pair.y, (at & 8u) != 0u);
            coarsest = max(coarsest, (word >> (4u * (at & 7u))) & 15u);
        }
    }
    return coarsest;
}

// Level of the coarsest cells between a point, its lifted self and the kernel's ends; `lift` in cells.
fn cubes_level(c: CubesParams, g: GridPosition, lift: vec3f) -> u32 {
    if (all(cubes_plan_counts() == vec2u(0u))) {
        return c.kernel.y;
    }
    let p = grid_fixed(c.grid, g, vec3f(0.0)).xz;
    var level = cubes_coarsest(p, p);
    loop {
        let size = f32(1u << level);
        // Farther than the margin it does not matter how far; more would leave 32 bits.
        let limit = f32(MARGIN_VOXELS) + f32(c.grid.size.x);
        let lifted = grid_fixed(c.grid, g, clamp(lift * size, vec3f(-limit), vec3f(limit))).xz;
        let margin = min((i32(c.kernel.z) + 1) << level, c.grid.size.x) * FIXED_ONE;
        let coarsest = cubes_coarsest(min(p, lifted) - margin, max(p, lifted) + margin);
        if (coarsest <= level) {
            return level;
        }
        level = coarsest;
    }
    // Not reached; some compilers ask for it.
    return level;
}

// Where the ray from a point, voxels, towards the sun first lies in the cube; w = 0 where it never does.
fn cubes_entry(c: CubesParams, p: vec3f) -> vec4f {
    let side = f32(c.grid.size.x);
    let d = c.towards_sun.xyz;
    // A ray along a face of its axis never meets the others: it lies between them or not.
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

fn cubes_place(c: CubesParams, s: Surface) -> CubesPlace {
    let towards_sun = c.towards_sun.xyz;
    let n_dot_l = dot(s.normal, towards_sun);
    let tangent = length(s.normal - n_dot_l * towards_sun);
    var slope = 0.0;
    if (tangent > 0.0) {
        slope = min(tangent / max(n_dot_l, tangent / MAX_SLOPE), MAX_SLOPE);
    }
    let lift = towards_sun * bias_along_light(c.bias, slope) + s.normal * c.bias.z;
    let g = grid_position(c.grid, s.p_relative);
    let level = cubes_level(c, g, lift);
    let size = f32(1u << level);
    let end = c.grid.size.x * FIXED_ONE;

    var place: CubesPlace;
    place.found = true;
    place.receiver.level = level;
    var moved = lift * size;
    place.receiver.p_fixed = grid_fixed(c.grid, g, moved);
    if (any(place.receiver.p_fixed < vec3i(0)) || any(place.receiver.p_fixed >= vec3i(end))) {
        let entry = cubes_entry(c, g.voxels + moved);
        place.found = entry.w > 0.0;
        moved = entry.xyz - g.voxels;
        place.receiver.p_fixed = vec3i(floor(entry.xyz * f32(FIXED_ONE)));
    }
    place.receiver.p_fixed = clamp(place.receiver.p_fixed, vec3i(0), vec3i(end - 1));
    if (c.taps.x == 0u) {
        let height = dot(s.normal, moved) / size * f32(NORMAL_ONE) + 0.5;
        let most = MAX_HEIGHT_CELLS * NORMAL_ONE;
        place.receiver.normal = vec3i(floor(s.normal * f32(NORMAL_ONE) + 0.5));
        place.receiver.height = clamp(i32(floor(height)), -most, most);
    }
    return place;
}

fn cubes_factor(c: CubesParams, s: Surface) -> f32 {
    let place = cubes_place(c, s);
    if (!place.found) {
        return 1.0;
    }
    let sum = cubes_lit_weights(c, place.receiver);
    return f32(sum.x) / f32(sum.y);
}
