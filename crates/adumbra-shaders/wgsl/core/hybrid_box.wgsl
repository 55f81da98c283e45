// The mean of comparisons over a square of a hybrid map: what core/pcf.wgsl's pcf_box is for a shadow map, over the same finest texels with
// the same weights. Texels that merged are compared as a whole, by the extremes of what a plane less a plane can be; only where those
// disagree are their finest texels taken one by one.

struct HybridBox {
    // Of the square, in finest texels.
    low: vec2f,
    high: vec2f,
    receiver: MapReceiver,
}

// How a receiver compares with a texel: 1 lit all over, 0 shadowed all over, 0.5 neither.
fn hybrid_compare(box: HybridBox, leaf: vec3f, middle: vec2f, corner: vec2f, size: f32) -> f32 {
    let r = box.receiver;
    // Centres of the finest texels that both hold.
    let first = max(corner, floor(box.low)) + 0.5;
    let last = min(corner + size, ceil(box.high)) - 0.5;
    let reach = 0.5 * (last - first);
    let centre = 0.5 * (first + last);
    let caster = leaf.x + dot(leaf.yz, centre - middle);
    let slant = r.gradient - leaf.yz;
    // Receiver less caster: where the receiver's plane counts, and where its deepest does.
    let plane = r.depth + dot(r.gradient, centre - r.p_texels) - caster;
    let plane_reach = dot(abs(slant), reach);
    let flat = r.deepest - caster;
    let flat_reach = dot(abs(leaf.yz), reach);
    if (min(plane + plane_reach, flat + flat_reach) <= 0.0) {
        return 1.0;
    }
    return select(0.5, 0.0, min(plane - plane_reach, flat - flat_reach) > 0.0);
}

// Finest texels' area that the square and a texel of `size` share.
fn hybrid_area(box: HybridBox, corner: vec2f, size: f32) -> f32 {
    let sides = max(min(corner + size, box.high) - max(corner, box.low), vec2f(0.0));
    return sides.x * sides.y;
}

// Lit area of a texel that merged.
fn hybrid_leaf_area(params: HybridParams, box: HybridBox, word: u32, texel: vec2u, level: u32) -> f32 {
    let size = f32(1u << level);
    let corner = vec2f(texel) * size;
    let middle = corner + 0.5 * size;
    let leaf = hybrid_leaf(word, params.slope.x);
    let lit = hybrid_compare(box, leaf, middle, corner, size);
    if (lit != 0.5) {
        return lit * hybrid_area(box, corner, size);
    }
    let first = max(corner, floor(box.low));
    let last = min(corner + size, ceil(box.high));
    var area = 0.0;
    for (var y = first.y; y < last.y; y += 1.0) {
        for (var x = first.x; x < last.x; x += 1.0) {
            let p = vec2f(x, y);
            let depth = leaf.x + dot(leaf.yz, p + 0.5 - middle);
            let passed = map_plane_depth(box.receiver, p + 0.5) <= depth;
            area += select(0.0, hybrid_area(box, p, 1.0), passed);
        }
    }
    return area;
}

// Lit area of the four finest texels below `parent`, whose place in level 1 is `texel`.
fn hybrid_finest_area(params: HybridParams, box: HybridBox, parent: u32, texel: vec2u) -> f32 {
    var area = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let finest = 2u * texel + vec2u(i & 1u, i >> 1u);
        let p = vec2f(finest);
        let share = hybrid_area(box, p, 1.0);
        if (share > 0.0) {
            let depth = hybrid_finest(parent, finest, params.counts.w == 1u);
            area += select(0.0, share, map_plane_depth(box.receiver, p + 0.5) <= depth);
        }
    }
    return area;
}

fn hybrid_area_1(params: HybridParams, box: HybridBox, word: u32, texel: vec2u) -> f32 {
    if (hybrid_is_index(word)) {
        return hybrid_finest_area(params, box, word, texel);
    }
    return hybrid_leaf_area(params, box, word, texel, 1u);
}

fn hybrid_area_2(params: HybridParams, box: HybridBox, word: u32, texel: vec2u) -> f32 {
    if (!hybrid_is_index(word)) {
        return hybrid_leaf_area(params, box, word, texel, 2u);
    }
    var area = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let child = 2u * texel + vec2u(i & 1u, i >> 1u);
        if (hybrid_area(box, 2.0 * vec2f(child), 2.0) > 0.0) {
            area += hybrid_area_1(params, box, hybrid_child(word, child), child);
        }
    }
    return area;
}

fn hybrid_area_3(params: HybridParams, box: HybridBox, word: u32, texel: vec2u) -> f32 {
    if (!hybrid_is_index(word)) {
        return hybrid_leaf_area(params, box, word, texel, 3u);
    }
    var area = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let child = 2u * texel + vec2u(i & 1u, i >> 1u);
        if (hybrid_area(box, 4.0 * vec2f(child), 4.0) > 0.0) {
            area += hybrid_area_2(params, box, hybrid_child(word, child), child);
        }
    }
    return area;
}

// Lit area of a texel of the coarsest level.
fn hybrid_cell_area(params: HybridParams, box: HybridBox, word: u32, cell: vec2u) -> f32 {
    switch params.counts.y {
        case 1u: { return hybrid_area_1(params, box, word, cell); }
        case 2u: { return hybrid_area_2(params, box, word, cell); }
        default: { return hybrid_area_3(params, box, word, cell); }
    }
}

// The mean over a square of `width` - 1 finest texels around the receiver. Beyond the map is lit.
fn hybrid_box(params: HybridParams, r: MapReceiver, width: u32) -> f32 {
    let half_side = 0.5 * (f32(width) - 1.0);
    let box = HybridBox(r.p_texels - half_side, r.p_texels + half_side, r);
    let level = params.counts.y;
    let size = f32(1u << level);
    let side = params.counts.x >> level;
    let first = vec2i(floor(box.low / size));
    let last = vec2i(ceil(box.high / size)) - 1;
    // Where no texel of the coarsest level leads further down and all agree, that is the answer.
    var lit = true;
    var shadowed = true;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let cell = vec2u(clamp(vec2i(x, y), vec2i(0), vec2i(i32(side) - 1)));
            let word = hybrid_root(cell, side);
            var answer = 0.5;
            if (!hybrid_is_index(word)) {
                let corner = vec2f(cell) * size;
                answer = hybrid_compare(box, hybrid_leaf(word, params.slope.x), corner + 0.5 * size, corner, size);
            }
            lit = lit && answer == 1.0;
            shadowed = shadowed && answer == 0.0;
        }
    }
    if (lit || shadowed) {
        return select(0.0, 1.0, lit);
    }
    var area = 0.0;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let cell = vec2i(x, y);
            if (any(cell < vec2i(0)) || any(cell >= vec2i(i32(side)))) {
                area += hybrid_area(box, vec2f(cell) * size, size);
            } else {
                area += hybrid_cell_area(params, box, hybrid_root(vec2u(cell), side), vec2u(cell));
            }
        }
    }
    return area / (4.0 * half_side * half_side);
}
