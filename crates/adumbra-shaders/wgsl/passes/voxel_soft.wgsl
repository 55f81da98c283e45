// The technique `voxel:soft`: penumbrae from the switch depths of a file.

@group(1) @binding(0) var<uniform> voxel_params: AdumbraVoxelParams;

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return adumbra_depths_soft(voxel_params, adumbra_voxel_receiver(voxel_params, s), adumbra_disc_turn(s.pixel));
}
