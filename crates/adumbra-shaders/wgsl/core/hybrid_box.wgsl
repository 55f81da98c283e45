// The mean of comparisons over a square of a hybrid map: the counterpart of adumbra_pcf_box in core/pcf.wgsl,
// over the same texels with the same weights. Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping
// Design, 2016, whose filter this is. The coarsest texels under the square are compared first, as whole
// planes. Finest texels are read only if one of the coarsest leads further down or if they disagree.

// Returns the comparison result that all coarsest texels under the square `low` to `high` share, 0 or 1; 0.5
// if they differ. The square is no wider than a coarsest texel, so it touches at most 2 × 2 of them. Results
// are exact: the difference of two planes has its extremes at corners. The result is 0.5 for a square that
// extends beyond the map.
fn adumbra_hybrid_agreed(shape: AdumbraHybridShape, r: AdumbraMapReceiver, low: vec2f, high: vec2f) -> f32 {
    if (any(low < vec2f(0.0)) || any(high > vec2f(f32(shape.start)))) {
        return 0.5;
    }
    let size = f32(1u << shape.merges);
    let side = shape.start >> shape.merges;
    let last_cell = vec2i(i32(side) - 1);
    let first = floor(low / size);
    let split = (first + 1.0) * size;
    // A column or row that the square does not reach repeats the first one.
    let one = high <= split;
    let second = select(first + 1.0, first, one);
    let near = clamp(vec2i(first), vec2i(0), last_cell);
    let far = clamp(vec2i(second), vec2i(0), last_cell);
    let words = vec4u(
        adumbra_hybrid_root(vec2u(near), side),
        adumbra_hybrid_root(vec2u(vec2i(far.x, near.y)), side),
        adumbra_hybrid_root(vec2u(vec2i(near.x, far.y)), side),
        adumbra_hybrid_root(vec2u(far), side),
    );
    if (any((words & vec4u(ADUMBRA_HYBRID_INDEX)) != vec4u(0u))) {
        return 0.5;
    }
    let a = adumbra_hybrid_leaf(words.x, shape.slope);
    let b = adumbra_hybrid_leaf(words.y, shape.slope);
    let c = adumbra_hybrid_leaf(words.z, shape.slope);
    let d = adumbra_hybrid_leaf(words.w, shape.slope);
    let slope_x = vec4f(a.y, b.y, c.y, d.y);
    let slope_y = vec4f(a.z, b.z, c.z, d.z);
    // Centres of the finest texels that the square and each coarsest texel share: the middle of their range,
    // and its half extent.
    let begin = floor(low) + 0.5;
    let end = ceil(high) - 0.5;
    let near_end = min(end, split - 0.5);
    let far_begin = select(split + 0.5, begin, one);
    let middle_x = 0.5 * vec2f(begin.x + near_end.x, far_begin.x + end.x).xyxy;
    let middle_y = 0.5 * vec2f(begin.y + near_end.y, far_begin.y + end.y).xxyy;
    let reach_x = 0.5 * vec2f(near_end.x - begin.x, end.x - far_begin.x).xyxy;
    let reach_y = 0.5 * vec2f(near_end.y - begin.y, end.y - far_begin.y).xxyy;
    let cell_x = ((vec2f(first.x, second.x) + 0.5) * size).xyxy;
    let cell_y = ((vec2f(first.y, second.y) + 0.5) * size).xxyy;
    let caster = vec4f(a.x, b.x, c.x, d.x) + slope_x * (middle_x - cell_x) + slope_y * (middle_y - cell_y);
    let plane = r.depth + r.gradient.x * (middle_x - r.p_texels.x) + r.gradient.y * (middle_y - r.p_texels.y) - caster;
    let plane_reach = abs(r.gradient.x - slope_x) * reach_x + abs(r.gradient.y - slope_y) * reach_y;
    let flat = r.deepest - caster;
    let flat_reach = abs(slope_x) * reach_x + abs(slope_y) * reach_y;
    if (all(min(plane + plane_reach, flat + flat_reach) <= vec4f(0.0))) {
        return 1.0;
    }
    return select(0.5, 0.0, all(min(plane - plane_reach, flat - flat_reach) > vec4f(0.0)));
}

// Returns the mean over a square of `width` - 1 finest texels around the receiver. Everything beyond the map
// is lit.
fn adumbra_hybrid_box(shape: AdumbraHybridShape, r: AdumbraMapReceiver, width: u32) -> f32 {
    let half_side = 0.5 * (f32(width) - 1.0);
    let low = r.p_texels - half_side;
    let high = r.p_texels + half_side;
    // A wider square would touch as many coarsest texels as there are blocks to read.
    if (width <= (1u << shape.merges) + 1u) {
        let agreed = adumbra_hybrid_agreed(shape, r, low, high);
        if (agreed != 0.5) {
            return agreed;
        }
    }
    let first = vec2i(floor(0.5 * low));
    let last_block = vec2i(i32(shape.start >> 1u) - 1);
    let pairs = i32((width + 1u) / 2u);
    var lit = 0.0;
    for (var y = 0; y < pairs; y++) {
        for (var x = 0; x < pairs; x++) {
            let block = first + vec2i(x, y);
            let inside = clamp(block, vec2i(0), last_block);
            var stored = vec4f(1.0);
            if (all(inside == block)) {
                stored = adumbra_hybrid_block(shape, vec2u(block));
            }
            let corner = 2.0 * vec2f(block) + 1.0;
            let middle = r.depth + dot(r.gradient, corner - r.p_texels);
            let right = 0.5 * r.gradient.x;
            let down = 0.5 * r.gradient.y;
            let plane = vec4f(middle - right - down, middle + right - down, middle - right + down, middle + right + down);
            let passed = select(vec4f(0.0), vec4f(1.0), min(plane, vec4f(r.deepest)) <= stored);
            let columns = adumbra_map_overlap(vec2f(corner.x - 1.0, corner.x), vec2f(low.x, high.x));
            let rows = adumbra_map_overlap(vec2f(corner.y - 1.0, corner.y), vec2f(low.y, high.y));
            lit += dot(passed, columns.xyxy * rows.xxyy);
        }
    }
    return lit / (4.0 * half_side * half_side);
}
