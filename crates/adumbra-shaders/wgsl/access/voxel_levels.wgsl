// The parameters of a streamed file's levels, the finest first, and the look-up in the finest level that has
// the pages. core/depths_blend.wgsl must precede this file. Source: spec/streaming.md.

@group(1) @binding(0) var<uniform> adumbra_voxel_levels: array<AdumbraVoxelParams, ADUMBRA_MAX_LEVELS>;

fn adumbra_level_count() -> u32 {
    return 1u + adumbra_voxel_levels[0].extra.y;
}

fn adumbra_file_factor(s: AdumbraSurface) -> f32 {
    var blend = vec2f(0.0, 1.0);
    for (var level = 0u; blend.y > 0.0 && level < adumbra_level_count(); level++) {
        let v = adumbra_voxel_levels[level];
        blend = adumbra_blend(blend, v, s, adumbra_voxel_factor(v, s));
    }
    return blend.x;
}
