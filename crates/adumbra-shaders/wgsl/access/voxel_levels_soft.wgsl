// Penumbrae in a streamed file, from the finest level that has all pages that they may need.
// access/voxel_levels.wgsl, core/disc.wgsl and core/depths_soft.wgsl must precede this file.

fn adumbra_file_soft(s: AdumbraSurface) -> f32 {
    let turn = adumbra_disc_turn(s.pixel);
    var blend = vec2f(0.0, 1.0);
    for (var level = 0u; blend.y > 0.0 && level < adumbra_level_count(); level++) {
        let v = adumbra_voxel_levels[level];
        blend = adumbra_blend(blend, v, s, adumbra_depths_soft(v, adumbra_voxel_receiver(v, s), turn));
    }
    return blend.x;
}
