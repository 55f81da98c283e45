// The technique `voxel+csm`: static casters from a light-aligned file, movers from cascades that contain
// only movers. The result is the darker of the two. Receivers may be static or moving.

@group(1) @binding(0) var<uniform> voxel_params: AdumbraVoxelParams;

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    let from_file = adumbra_voxel_factor(voxel_params, s);
    if (from_file == 0.0) {
        return 0.0;
    }
    return min(from_file, map_visibility(s));
}
