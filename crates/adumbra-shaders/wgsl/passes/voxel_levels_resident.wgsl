// The level of a streamed file that answers, 0 = the finest in use; -1 for points beside or in front of the
// grid, where nothing is looked up.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    if (adumbra_voxel_of(adumbra_voxel_levels[0], adumbra_voxel_receiver(adumbra_voxel_levels[0], s)).z < 0) {
        return -1.0;
    }
    var level = 0u;
    while (level + 1u < adumbra_level_count() && adumbra_voxel_factor(adumbra_voxel_levels[level], s) < 0.0) {
        level++;
    }
    return f32(level);
}
