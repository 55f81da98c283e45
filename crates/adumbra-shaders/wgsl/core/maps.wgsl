// A receiver in a layer of a shadow map. Light depth is linear, 0 near the sun, 1 far. Texel coordinates
// start at the layer's left and top edges; texel centres are at half-integers. Source of the receiver plane:
// Isidoro, Shadow Mapping: GPU-based Tips and Techniques, 2006. Here the plane comes from the known geometric
// normal instead of screen-space derivatives, so it is correct at silhouettes and cascade seams too.

struct AdumbraMapReceiver {
    p_texels: vec2f,
    // Biased depth.
    depth: f32,
    // Upper limit of the compared depth: the point's own. Beyond a crease the plane continues below the
    // surface, which would then shadow it.
    deepest: f32,
    // Change of the surface's depth per texel to the right and per texel downwards.
    gradient: vec2f,
    layer: i32,
}

fn adumbra_map_gradient(layer: AdumbraMapLayer, size: u32, s: AdumbraSurface) -> vec2f {
    // The length of each row is one over the layer's side length.
    let edge_world = layer.texel_world * f32(size);
    let n = edge_world * vec2f(dot(layer.u_from_relative.xyz, s.normal), dot(layer.v_from_relative.xyz, s.normal));
    let tangent = length(n);
    if (tangent == 0.0) {
        return vec2f(0.0);
    }
    return n / max(dot(s.normal, s.towards_sun), tangent / ADUMBRA_MAX_SLOPE) * (layer.texel_world / layer.depth_world);
}

// `min_bias_depth`, a fraction of the layer's depth, is the largest distance by which rounding can separate a
// caster and a receiver: see DepthPrecision::min_bias_depth.
fn adumbra_map_receiver(
    layer: AdumbraMapLayer,
    index: u32,
    size: u32,
    bias: AdumbraReceiverBias,
    min_bias_depth: f32,
    s: AdumbraSurface,
) -> AdumbraMapReceiver {
    let unit_world = layer.texel_world * bias.width_factor;
    let moved = s.p_relative + s.normal * (bias.normal_offset_texels * unit_world);
    let p = adumbra_map_layer_position(layer, moved);
    let towards_sun = adumbra_bias_along_light(bias, adumbra_surface_slope(s)) * unit_world / layer.depth_world;
    var r: AdumbraMapReceiver;
    r.p_texels = p.xy * f32(size);
    r.depth = p.z - max(towards_sun, min_bias_depth);
    r.deepest = min(r.depth, 1.0);
    r.gradient = adumbra_map_gradient(layer, size, s);
    r.layer = i32(index);
    return r;
}

// Returns the depth that a texel of the layer is compared with: that of the receiver's plane, but never
// behind the depth that a texel without a caster holds.
fn adumbra_map_plane_depth(r: AdumbraMapReceiver, p_texels: vec2f) -> f32 {
    return min(r.depth + dot(r.gradient, p_texels - r.p_texels), r.deepest);
}

// Returns the receiver moved along its plane.
fn adumbra_map_moved(r: AdumbraMapReceiver, offset_texels: vec2f) -> AdumbraMapReceiver {
    var moved = r;
    moved.p_texels = r.p_texels + offset_texels;
    moved.depth = r.depth + dot(r.gradient, offset_texels);
    return moved;
}

// Returns the position of a view depth within a band: 0 in front of it, 1 behind it.
fn adumbra_map_band(begin: f32, end: f32, view_depth: f32) -> f32 {
    return select(clamp((view_depth - begin) / (end - begin), 0.0, 1.0), 0.0, view_depth <= begin);
}

// Returns how much of the texel that starts at `left` is within a span.
fn adumbra_map_overlap(left: vec2f, span: vec2f) -> vec2f {
    return clamp(min(left + 1.0, vec2f(span.y)) - max(left, vec2f(span.x)), vec2f(0.0), vec2f(1.0));
}
