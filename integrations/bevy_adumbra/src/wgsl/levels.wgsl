// Returns the visibility of a point from the selected file.
fn visibility(p_world: vec3<f32>, normal: vec3<f32>, towards_sun: vec3<f32>, pixel: vec2<f32>) -> f32 {
    adumbra_finest_level();
    let s = surface_at(p_world, normal, towards_sun, pixel);
    // Where a page is not resident, a coarser level answers. While a page fades in or out, a coarser level
    // has a share.
    var blend = vec2<f32>(0.0, 1.0);
    loop {
        let v = adumbra_texture_params();
        blend = adumbra_blend(blend, v, s, look_up(v, s));
        if (blend.y <= 0.0 || !adumbra_coarser_level()) {
            break;
        }
    }
    return blend.x;
}
