// The parameters of two keys of a sun path, and the ray to a sun between theirs. core/depths_march.wgsl must precede this
// file; access/voxel_path_filter.wgsl or access/voxel_path_disc.wgsl follows it. Source: spec/sun-path.md.

struct AdumbraPath {
    // The key that is asked first, and the other one.
    keys: array<AdumbraVoxelParams, 2>,
    // Of either key, texels aside per voxel nearer to the sun, in 2^-16. The third component of the first one is 1 if rays are
    // marched only where the keys' own answers differ; its fourth is for how many voxels a ray must be hidden from both keys to be
    // taken to meet something, 0 = never.
    ways: array<vec4i, 2>,
}

@group(1) @binding(0) var<uniform> adumbra_path: AdumbraPath;

// Follows a ray through a key: to a point of the sun's disc, which has radius 1 and is that of the parameters.
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
