// A point as a layer of a shadow map sees it. Light depth is linear, 0 near the sun, 1 far; texels are counted from the layer's left
// and top edge, their centres at halves.
// Source of the receiver's plane: Isidoro, Shadow Mapping: GPU-based Tips and Techniques, 2006. Here the plane comes from the known
// geometric normal instead of screen derivatives, so it holds at silhouettes and cascade seams too.

struct MapReceiver {
    p_texels: vec2f,
    // After the bias.
    depth: f32,
    // No comparison is with a depth behind this: the point's own. Beyond a crease the plane runs below the surface, which would
    // shadow it.
    deepest: f32,
    // Change of the surface's depth a texel to the right and a texel down.
    gradient: vec2f,
    layer: i32,
}

fn map_gradient(layer: MapLayer, size: u32, s: Surface) -> vec2f {
    // The rows' lengths are one over the layer's edge.
    let edge_world = layer.scale.x * f32(size);
    let n = edge_world * vec2f(dot(layer.u_from_relative.xyz, s.normal), dot(layer.v_from_relative.xyz, s.normal));
    let tangent = length(n);
    if (tangent == 0.0) {
        return vec2f(0.0);
    }
    return n / max(dot(s.normal, s.towards_sun), tangent / MAX_SLOPE) * (layer.scale.x / layer.scale.y);
}

// `bias` as in MapParams. `least_bias`, a share of the layer's depth, is what rounding may move a caster and a receiver apart: see
// DepthPrecision::least_bias.
fn map_receiver(layer: MapLayer, index: u32, size: u32, bias: vec4f, least_bias: f32, s: Surface) -> MapReceiver {
    let unit_world = layer.scale.x * bias.w;
    let p = s.p_relative + s.normal * (bias.z * unit_world);
    let u = dot(layer.u_from_relative.xyz, p) + layer.u_from_relative.w;
    let v = dot(layer.v_from_relative.xyz, p) + layer.v_from_relative.w;
    let depth = dot(layer.depth_from_relative.xyz, p) + layer.depth_from_relative.w;
    var r: MapReceiver;
    r.p_texels = vec2f(u, v) * f32(size);
    r.depth = depth - max(bias_along_light(bias, surface_slope(s)) * unit_world / layer.scale.y, least_bias);
    r.deepest = min(r.depth, 1.0);
    r.gradient = map_gradient(layer, size, s);
    r.layer = i32(index);
    return r;
}

// What a texel at a place of the layer is compared with: the receiver's plane there. Never behind what a texel without a caster holds.
fn map_plane_depth(r: MapReceiver, p_texels: vec2f) -> f32 {
    return min(r.depth + dot(r.gradient, p_texels - r.p_texels), r.deepest);
}

// The receiver, moved along its plane.
fn map_moved(r: MapReceiver, offset_texels: vec2f) -> MapReceiver {
    var moved = r;
    moved.p_texels = r.p_texels + offset_texels;
    moved.depth = r.depth + dot(r.gradient, offset_texels);
    return moved;
}

// How far a view depth lies in a band: 0 before it, 1 behind it.
fn map_band(begin: f32, end: f32, view_depth: f32) -> f32 {
    return select(clamp((view_depth - begin) / (end - begin), 0.0, 1.0), 0.0, view_depth <= begin);
}

// How much of the texel from `left` lies within a span.
fn map_overlap(left: vec2f, span: vec2f) -> vec2f {
    return clamp(min(left + 1.0, vec2f(span.y)) - max(left, vec2f(span.x)), vec2f(0.0), vec2f(1.0));
}
