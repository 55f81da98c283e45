fn adumbra_look_up(v: AdumbraVoxelParams, s: AdumbraSurface) -> f32 {
    return adumbra_voxel_factor(v, s);
}
