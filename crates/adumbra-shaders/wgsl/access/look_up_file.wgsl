// The look-up in a file that is a look-up texture, without buffer bindings. core/depths_blend.wgsl,
// core/disc.wgsl, core/depths_soft.wgsl and access/look_up_parameters.wgsl must precede this file.

fn adumbra_file_factor(s: AdumbraSurface) -> f32 {
    adumbra_finest_level();
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

fn adumbra_file_soft(s: AdumbraSurface) -> f32 {
    adumbra_finest_level();
    let turn = adumbra_disc_turn(s.pixel);
    var blend = vec2f(0.0, 1.0);
    loop {
        let v = adumbra_texture_params();
        blend = adumbra_blend(blend, v, s, adumbra_depths_soft(v, adumbra_voxel_receiver(v, s), turn));
        if (blend.y <= 0.0 || !adumbra_coarser_level()) {
            break;
        }
    }
    return blend.x;
}
