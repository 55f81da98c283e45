// The technique `voxel+csm`: static casters from a light-aligned file, movers from cascades that contain only
// movers. The result is the darker of the two. Receivers may be static or moving. `adumbra_file_factor` is
// from access/voxel_params.wgsl or access/voxel_levels.wgsl.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    let from_file = adumbra_file_factor(s);
    if (from_file == 0.0) {
        return 0.0;
    }
    return min(from_file, map_visibility(s));
}
