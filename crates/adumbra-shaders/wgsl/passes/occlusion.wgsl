// Ambient visibility of each texel: the pass that calls an estimator, which is a function
//     fn ambient_visibility(c: OcclusionCenter) -> f32      1 = unoccluded
// in a file of its own. Writes visibility and view depth together, so that filters read one texture. One
// thread per texel.

@group(0) @binding(0) var<uniform> occlusion: AdumbraOcclusionParams;
@group(0) @binding(1) var<uniform> noise: AdumbraOcclusionTaps;
@group(0) @binding(2) var view_depths: texture_2d<f32>;
@group(0) @binding(3) var normals: texture_2d<f32>;
@group(0) @binding(4) var ambient_out: texture_storage_2d<rg32float, write>;

// The visible point whose occlusion is estimated.
struct OcclusionCenter {
    texel: vec2i,
    // Position in view space.
    p: vec3f,
    // Unit normal in view space, towards the viewer.
    n: vec3f,
    // Radius of the search region: the requested one, or less if that would cover too many texels.
    radius_world: f32,
    radius_texels: f32,
    // Index of this texel's first tap among all taps.
    first_tap: u32,
}

fn is_inside(texel: vec2i) -> bool {
    return all(texel >= vec2i(0)) && all(texel < vec2i(occlusion.size));
}

// Returns the view depth of a texel inside the picture; 0 if there is no surface.
fn view_depth_at(texel: vec2i) -> f32 {
    return textureLoad(view_depths, texel, 0).x;
}

fn point_at(texel: vec2i, z: f32) -> vec3f {
    return adumbra_occlusion_point(occlusion.view, texel, z);
}

fn center_at(texel: vec2u, z: f32) -> OcclusionCenter {
    let n = textureLoad(normals, texel * occlusion.pixels_per_normal, 0).xyz;
    var c: OcclusionCenter;
    c.texel = vec2i(texel);
    c.p = point_at(c.texel, z);
    c.n = normalize(adumbra_occlusion_direction(occlusion.view, n));
    let texels = occlusion.radius_world / (occlusion.texel_world + occlusion.texel_world_per_depth * z);
    // The region shrinks as a whole: its contents are weighted as in a region of that size, and nothing is
    // cut off.
    let share = min(1.0, occlusion.max_radius_texels / texels);
    c.radius_texels = texels * share;
    c.radius_world = occlusion.radius_world * share;
    let tile = (adumbra_occlusion_tile_index(texel) + occlusion.tile_offset) & 15u;
    c.first_tap = tile * ADUMBRA_OCCLUSION_MAX_TAPS;
    return c;
}

@compute @workgroup_size(ADUMBRA_PIXEL_GROUP, ADUMBRA_PIXEL_GROUP)
fn occlude(@builtin(global_invocation_id) id: vec3u) {
    if (any(id.xy >= occlusion.size)) {
        return;
    }
    let z = view_depth_at(vec2i(id.xy));
    var visibility = 1.0;
    if (z > 0.0) {
        let c = center_at(id.xy, z);
        if (c.radius_texels >= 0.5) {
            visibility = ambient_visibility(c);
        }
    }
    textureStore(ambient_out, id.xy, vec4f(visibility, z, 0.0, 0.0));
}
