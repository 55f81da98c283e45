// The level at which a look-up in a streamed file ends, in voxels of the finest level in use; -1 outside the
// file. The look-up is in the finest level that has the page of the point.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    var end = -1;
    for (var level = 0u; level < adumbra_level_count(); level++) {
        let v = adumbra_voxel_levels[level];
        let r = adumbra_voxel_receiver(v, s);
        let asked = adumbra_voxel_of(v, r);
        if (asked.z < 0) {
            return -1.0;
        }
        end = adumbra_voxel_end_level(v, r) + 2 * i32(level);
        let column = vec2u(asked.xy) >> vec2u(v.root_level);
        if (adumbra_voxel_word(v.extra.x + 2u * (column.y * v.root_count.x + column.x)) != ADUMBRA_DEPTHS_ABSENT) {
            break;
        }
    }
    return f32(end);
}
