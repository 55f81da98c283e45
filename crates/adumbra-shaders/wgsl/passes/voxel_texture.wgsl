// The technique `voxel` from a look-up texture alone, without buffer bindings.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return adumbra_voxel_factor(adumbra_texture_params(), s);
}
