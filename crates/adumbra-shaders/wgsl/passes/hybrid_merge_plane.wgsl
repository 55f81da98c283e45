// The plane merge test: a block merges if there is a plane, packed as in core/hybrid_plane.wgsl, such that no
// finest texel of the block is behind it and none is further in front of it than the tolerance. Everything
// that is lit by a shadow map is therefore lit by the hybrid one too, and no gap wider than the tolerance is
// lost. The arithmetic is in integers, so that every machine builds the same map.

// Returns the four finest depths of a texel of level 1 in steps of 1 / ADUMBRA_HYBRID_ONE, rounded away from
// the sun.
fn block_steps(block: vec2u) -> vec4i {
    return vec4i(ceil(block_depths(block) * ADUMBRA_HYBRID_ONE));
}

// Returns the code whose slope is nearest to `slope`; the smaller code in case of a tie.
fn slope_code(slope: i32) -> i32 {
    let unit = level.slope_unit;
    let size = abs(slope);
    let about = min(i32(sqrt(f32(size) * f32(1u << ADUMBRA_HYBRID_SLOPE_BITS) / f32(unit))), ADUMBRA_HYBRID_LAST_SLOPE);
    var best = 0;
    var best_off = size;
    for (var q = max(about - 1, 1); q <= min(about + 1, ADUMBRA_HYBRID_LAST_SLOPE); q++) {
        let off = abs(adumbra_hybrid_slope(q, unit) - size);
        if (off < best_off) {
            best = q;
            best_off = off;
        }
    }
    return select(best, -best, slope < 0);
}

fn block_merged(block: vec2u) -> u32 {
    let made = level.number;
    // Depths at the centres of the four children, which are 2^(made - 1) texels apart.
    var d: vec4i;
    if (made == 1u) {
        d = block_steps(block);
    } else {
        let words = block_children(block);
        if (any((words & vec4u(ADUMBRA_HYBRID_INDEX)) != vec4u(0u))) {
            return ADUMBRA_HYBRID_INDEX;
        }
        d = vec4i(
            adumbra_hybrid_middle(words.x),
            adumbra_hybrid_middle(words.y),
            adumbra_hybrid_middle(words.z),
            adumbra_hybrid_middle(words.w),
        );
    }
    let apart = i32(1u << made);
    let code_x = slope_code(((d.y + d.w) - (d.x + d.z)) / apart);
    let code_y = slope_code(((d.z + d.w) - (d.x + d.y)) / apart);
    let slope = vec2i(adumbra_hybrid_slope(code_x, level.slope_unit), adumbra_hybrid_slope(code_y, level.slope_unit));
    // Twice the depth that each finest texel requires at the block's centre, in groups of four. Offsets from
    // the centre are in half texels.
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
    let smallest = min(min(nearest.x, nearest.y), min(nearest.z, nearest.w));
    let largest = max(max(farthest.x, farthest.y), max(farthest.z, farthest.w));
    let depth_code = max((largest + 2 * ADUMBRA_HYBRID_DEPTH_STEP - 1) / (2 * ADUMBRA_HYBRID_DEPTH_STEP) - 1, 0);
    let middle = (depth_code + 1) * ADUMBRA_HYBRID_DEPTH_STEP;
    if (depth_code > ADUMBRA_HYBRID_LAST_DEPTH || 2 * middle - smallest > level.twice_tolerance) {
        return ADUMBRA_HYBRID_INDEX;
    }
    return (u32(depth_code) << 14u) | ((u32(code_y) & 127u) << 7u) | (u32(code_x) & 127u);
}
