// The technique `voxel`: a light-aligned file, filtered over K × K texels. `adumbra_file_factor` is from
// access/voxel_params.wgsl, access/voxel_levels.wgsl or access/look_up_file.wgsl.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return adumbra_file_factor(s);
}
