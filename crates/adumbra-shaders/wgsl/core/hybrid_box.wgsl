// The mean of comparisons over a square of a hybrid map: what core/pcf.wgsl's pcf_box is for a shadow map, over the same finest texels with
// the same weights.
// Source: Li, Yang, Zhao, Chen, Hybrid-resolution Shadow Mapping Design, 2016, of which this is the filter: the coarsest texels under the
// square are asked first, as whole planes, and only where one of them leads further down, or they disagree, finest texels are.

// The square: `low` to `high` in finest texels, and who is compared.
struct HybridBox {
    low: vec2f,
    high: vec2f,
    receiver: MapReceiver,
}

// How a receiver compares with a texel of the coarsest level: 1 lit all over, 0 shadowed all over, 0.5 neither.
fn hybrid_compare(box: HybridBox, leaf: vec3f, corner: vec2f, size: f32) -> f32 {
    let r = box.receiver;
    // Centres of the finest texels that both hold.
    let first = max(corner, floor(box.low)) + 0.5;
    let last = min(corner + size, ceil(box.high)) - 0.5;
    let reach = 0.5 * (last - first);
    let centre = 0.5 * (first + last);
    let caster = leaf.x + dot(leaf.yz, centre - (corner + 0.5 * size));
    // Receiver less caster: where the receiver's plane counts, and where its deepest does.
    let plane = r.depth + dot(r.gradient, centre - r.p_texels) - caster;
    let plane_reach = dot(abs(r.gradient - leaf.yz), reach);
    let flat = r.deepest - caster;
    let flat_reach = dot(abs(leaf.yz), reach);
    if (min(plane + plane_reach, flat + flat_reach) <= 0.0) {
        return 1.0;
    }
    return select(0.5, 0.0, min(plane - plane_reach, flat - flat_reach) > 0.0);
}

// What all coarsest texels under the square agree on, 0 or 1; 0.5 where they do not.
fn hybrid_agreed(shape: HybridShape, box: HybridBox) -> f32 {
    let size = f32(1u << shape.merges);
    let side = shape.start >> shape.merges;
    let last_cell = vec2i(i32(side) - 1);
    let first = clamp(vec2i(floor(box.low / size)), vec2i(0), last_cell);
    let last = clamp(vec2i(ceil(box.high / size)) - 1, vec2i(0), last_cell);
    var sum = 0.0;
    var count = 0.0;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let word = hybrid_root(vec2u(vec2i(x, y)), side);
            if (hybrid_is_index(word)) {
                return 0.5;
            }
            sum += hybrid_compare(box, hybrid_leaf(word, shape.slope), vec2f(vec2i(x, y)) * size, size);
            count += 1.0;
        }
    }
    return select(select(0.5, 1.0, sum == count), 0.0, sum == 0.0);
}

// The mean over a square of `width` - 1 finest texels around the receiver. Beyond the map is lit.
fn hybrid_box(shape: HybridShape, r: MapReceiver, width: u32) -> f32 {
    let half_side = 0.5 * (f32(width) - 1.0);
    let low = r.p_texels - half_side;
    let high = r.p_texels + half_side;
    // After one merge there are as many coarse texels as blocks.
    if (shape.merges > 1u) {
        let agreed = hybrid_agreed(shape, HybridBox(low, high, r));
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
                stored = hybrid_block(shape, vec2u(block));
            }
            let corner = 2.0 * vec2f(block) + 1.0;
            let middle = r.depth + dot(r.gradient, corner - r.p_texels);
            let right = 0.5 * r.gradient.x;
            let down = 0.5 * r.gradient.y;
            let plane = vec4f(middle - right - down, middle + right - down, middle - right + down, middle + right + down);
            let passed = select(vec4f(0.0), vec4f(1.0), min(plane, vec4f(r.deepest)) <= stored);
            let columns = map_overlap(vec2f(corner.x - 1.0, corner.x), vec2f(low.x, high.x));
            let rows = map_overlap(vec2f(corner.y - 1.0, corner.y), vec2f(low.y, high.y));
            lit += dot(passed, columns.xyxy * rows.xxyy);
        }
    }
    return lit / (4.0 * half_side * half_side);
}
