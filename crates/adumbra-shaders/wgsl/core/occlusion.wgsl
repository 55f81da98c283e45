// Conversions between texels and view space: x right, y up, z = view depth, in world units from the eye. See
// AdumbraOcclusionView.

// Returns the NDC of a texel's centre.
fn adumbra_occlusion_ndc(view: AdumbraOcclusionView, texel: vec2i) -> vec2f {
    return view.ndc_per_texel * vec2f(texel) + view.ndc_of_first_texel;
}

// Returns the view-space point at view depth z behind a texel's centre.
fn adumbra_occlusion_point(view: AdumbraOcclusionView, texel: vec2i, z: f32) -> vec3f {
    return vec3f(adumbra_occlusion_ndc(view, texel) * (view.half_view + view.half_view_per_depth * z), z);
}

// Projects a point to the screen, in texels; integers are texel centres.
fn adumbra_occlusion_texel(view: AdumbraOcclusionView, p: vec3f) -> vec2f {
    let ndc = p.xy / (view.half_view + view.half_view_per_depth * p.z);
    return (ndc - view.ndc_of_first_texel) / view.ndc_per_texel;
}

// Returns a texel's index in the 4 × 4 noise tile, in Bayer's order (An Optimum Method for Two-Level
// Rendition of Continuous-Tone Pictures, 1973): the indices of neighbouring texels are far apart.
fn adumbra_occlusion_tile_index(texel: vec2u) -> u32 {
    let x = texel.x & 3u;
    let y = texel.y & 3u;
    let d = x ^ y;
    return ((d & 1u) << 3u) | ((y & 1u) << 2u) | (d & 2u) | (y >> 1u);
}

// Transforms a world-space direction to view space.
fn adumbra_occlusion_direction(view: AdumbraOcclusionView, n_world: vec3f) -> vec3f {
    return vec3f(dot(n_world, view.right), dot(n_world, view.up), dot(n_world, view.forward));
}
