// The test of the plane: a block merges where one plane, as core/hybrid_plane.wgsl packs it, has no finest texel of the block behind it and
// none further before it than the tolerance. So what a shadow map lights a hybrid one lights too, and no gap wider than the tolerance
// is lost. In whole numbers: every machine builds the same map.

// The four finest depths of a texel of level 1 in steps of 1 / HYBRID_ONE, rounded away from the sun.
fn block_steps(block: vec2u) -> vec4i {
    return vec4i(ceil(block_depths(block) * HYBRID_ONE));
}

// The code whose slope is nearest to `slope`; the smaller of two that are.
fn slope_code(slope: i32) -> i32 {
    let unit = level.plane.x;
    let size = abs(slope);
    let about = min(i32(sqrt(f32(size) * f32(1u << HYBRID_SLOPE_BITS) / f32(unit))), HYBRID_LAST_SLOPE);
    var best = 0;
    var best_off = size;
    for (var q = max(about - 1, 1); q <= min(about + 1, HYBRID_LAST_SLOPE); q++) {
        let off = abs(hybrid_slope(q, unit) - size);
        if (off < best_off) {
            best = q;
            best_off = off;
        }
    }
    return select(best, -best, slope < 0);
}

fn block_merged(block: vec2u) -> u32 {
    let made = level.counts.y;
    // Depths at the middles of the four children, which lie 2^(made - 1) texels apart.
    var d: vec4i;
    if (made == 1u) {
        d = block_steps(block);
    } else {
        let words = block_children(block);
        if (any((words & vec4u(HYBRID_INDEX)) != vec4u(0u))) {
            return HYBRID_INDEX;
        }
        d = vec4i(hybrid_middle(words.x), hybrid_middle(words.y), hybrid_middle(words.z), hybrid_middle(words.w));
    }
    let apart = i32(1u << made);
    let code_x = slope_code(((d.y + d.w) - (d.x + d.z)) / apart);
    let code_y = slope_code(((d.z + d.w) - (d.x + d.y)) / apart);
    let slope = vec2i(hybrid_slope(code_x, level.plane.x), hybrid_slope(code_y, level.plane.x));
    // Twice what each finest depth asks of the depth at the middle, by blocks of four; offsets from the middle are in half texels.
    let right = vec4i(0, slope.x, 0, slope.x);
    let down = vec4i(0, 0, slope.y, slope.y);
    var nearest = vec4i(0x7fffffff);
    var farthest = vec4i(-0x7fffffff);
    for (var y = 0; y < apart; y += 2) {
        for (var x = 0; x < apart; x += 2) {
            if (made > 1u) {
                d = block_steps((block * u32(apart) + vec2u(vec2i(x, y))) / 2u);
            }
            let asked = 2 * (d - right - down) - slope.x * (2 * x + 1 - apart) - slope.y * (2 * y + 1 - apart);
            nearest = min(nearest, asked);
            farthest = max(farthest, asked);
        }
    }
    let least = min(min(nearest.x, nearest.y), min(nearest.z, nearest.w));
    let most = max(max(farthest.x, farthest.y), max(farthest.z, farthest.w));
    let depth_code = max((most + 2 * HYBRID_DEPTH_STEP - 1) / (2 * HYBRID_DEPTH_STEP) - 1, 0);
    let middle = (depth_code + 1) * HYBRID_DEPTH_STEP;
    if (depth_code > HYBRID_LAST_DEPTH || 2 * middle - least > level.plane.y) {
        return HYBRID_INDEX;
    }
    return (u32(depth_code) << 14u) | ((u32(code_y) & 127u) << 7u) | (u32(code_x) & 127u);
}
