// From texels to view space and back: x right, y up, z = view depth; world units, from the eye. See OcclusionParams.

// The visible point whose occlusion is asked for.
struct OcclusionCenter {
    texel: vec2i,
    // View space.
    p: vec3f,
    // Unit, towards the viewer, view space.
    n: vec3f,
    // Of the region that is searched: the radius asked for, or less where it would take too many texels.
    radius_world: f32,
    radius_texels: f32,
    // Of this texel's taps among all.
    first_tap: u32,
}

// The point behind a texel's centre.
fn occlusion_point(ndc_from_texel: vec4f, half_view: vec4f, texel: vec2i, z: f32) -> vec3f {
    let ndc = ndc_from_texel.xy * vec2f(texel) + ndc_from_texel.zw;
    return vec3f(ndc * (half_view.xy + half_view.zw * z), z);
}

// Where a point lies on the screen, in texels; whole numbers are centres.
fn occlusion_texel(ndc_from_texel: vec4f, half_view: vec4f, p: vec3f) -> vec2f {
    let ndc = p.xy / (half_view.xy + half_view.zw * p.z);
    return (ndc - ndc_from_texel.zw) / ndc_from_texel.xy;
}

// A texel's place in the 4 × 4 tile of noise, in Bayer's order (An Optimum Method for Two-Level Rendition of Continuous-Tone Pictures,
// 1973): neighbours are far apart in it.
fn occlusion_place(texel: vec2u) -> u32 {
    let x = texel.x & 3u;
    let y = texel.y & 3u;
    let d = x ^ y;
    return ((d & 1u) << 3u) | ((y & 1u) << 2u) | (d & 2u) | (y >> 1u);
}
