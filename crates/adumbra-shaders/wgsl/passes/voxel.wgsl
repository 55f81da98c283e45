// The technique `voxel`: a light-aligned file, filtered over K × K texels.

@group(1) @binding(0) var<uniform> voxel_params: AdumbraVoxelParams;

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return adumbra_voxel_factor(voxel_params, s);
}
