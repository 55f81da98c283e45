// The technique `voxel:soft`: penumbrae from the switch depths of a file.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return adumbra_depths_soft(adumbra_voxel_params, adumbra_voxel_receiver(adumbra_voxel_params, s), adumbra_disc_turn(s.pixel));
}
