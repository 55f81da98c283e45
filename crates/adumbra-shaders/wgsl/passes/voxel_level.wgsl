// The level at which a look-up in a light-aligned file ends; -1 outside the file.

@group(1) @binding(0) var<uniform> voxel_params: AdumbraVoxelParams;

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return f32(adumbra_voxel_end_level(voxel_params, adumbra_voxel_receiver(voxel_params, s)));
}
