fn adumbra_look_up(v: AdumbraVoxelParams, s: AdumbraSurface) -> f32 {
    return adumbra_depths_soft(v, adumbra_voxel_receiver(v, s), adumbra_disc_turn(s.pixel));
}
