// The technique `voxel:soft`: penumbrae from the switch depths of a file. `adumbra_file_soft` is from
// access/voxel_params_soft.wgsl, access/voxel_levels_soft.wgsl or access/look_up_file.wgsl.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return adumbra_file_soft(s);
}
