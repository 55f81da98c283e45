// The parameters of two keys of a sun path, and the ray to a sun between the keys' suns.
// core/depths_march.wgsl must precede this file; access/voxel_path_filter.wgsl or access/voxel_path_disc.wgsl
// follows it. Source: spec/sun-path.md.

struct AdumbraPath {
    // The key in which rays are marched first, and the other key.
    keys: array<AdumbraVoxelParams, 2>,
    // x and y, for each key: the slope of the ray, in texels per voxel nearer to the sun, in 2^-16. z of the
    // first: 1 if rays are marched only where the keys' own answers differ. w of the first: a ray that is
    // hidden from both keys for this many voxels counts as blocked; 0 = never.
    ways: array<vec4i, 2>,
}

@group(1) @binding(0) var<uniform> adumbra_path: AdumbraPath;

// Marches a ray in a key to a point of the sun's disc. The disc has radius 1; its angle is in the parameters.
fn adumbra_path_march(key: u32, s: AdumbraSurface, tap: vec2i, on_disc: vec2f) -> u32 {
    let v = adumbra_path.keys[key];
    let aside = v.sun_cone * vec2f(dot(v.penumbra_x, on_disc), dot(v.penumbra_y, on_disc));
    let slope = adumbra_path.ways[key].xy + vec2i(floor(65536.0 * aside));
    return adumbra_march(v, slope, adumbra_march_start(v, slope, s, tap));
}

fn adumbra_path_is_lit(s: AdumbraSurface, tap: vec2i, on_disc: vec2f) -> bool {
    let first = adumbra_path_march(0u, s, tap, on_disc);
    if (first < ADUMBRA_MARCH_UNKNOWN) {
        return first == ADUMBRA_MARCH_CLEAR;
    }
    let other = adumbra_path_march(1u, s, tap, on_disc);
    if (other < ADUMBRA_MARCH_UNKNOWN) {
        return other == ADUMBRA_MARCH_CLEAR;
    }
    return !adumbra_march_is_guessed_dark(first, other, u32(adumbra_path.ways[0].w));
}
