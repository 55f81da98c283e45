// The technique `voxel`: a light-aligned file, filtered over K × K texels. `adumbra_file_factor` is from
// access/voxel_params.wgsl or access/voxel_levels.wgsl.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return adumbra_file_factor(s);
}
