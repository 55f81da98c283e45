// The technique `voxel` from a look-up texture alone, without buffer bindings.

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    var blend = vec2f(0.0, 1.0);
    loop {
        let v = adumbra_texture_params();
        blend = adumbra_blend(blend, v, s, adumbra_voxel_factor(v, s));
        if (blend.y <= 0.0 || !adumbra_coarser_level()) {
            break;
        }
    }
    return blend.x;
}
