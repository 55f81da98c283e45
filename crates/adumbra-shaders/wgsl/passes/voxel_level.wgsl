// The level at which a look-up in a light-aligned file ends; -1 outside the file.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return f32(adumbra_voxel_end_level(adumbra_voxel_params, adumbra_voxel_receiver(adumbra_voxel_params, s)));
}
