// The visibility of one light from its files. surface.wgsl and `adumbra_look_up` come before this text,
// main.wgsl after it.

// A point at least this many texels inside a file's grid needs no better file.
const ADUMBRA_FAR_INSIDE: i32 = 8;

// Returns how far inside the selected file's grid a point is, texels; negative outside.
fn adumbra_texels_inside(p_world: vec3f) -> i32 {
    let v = adumbra_texture_params();
    let r = adumbra_voxel_receiver(v, adumbra_surface_at(p_world, vec3f(0.0), vec2f(0.0)));
    let texel = r.p_fixed.xy >> vec2u(ADUMBRA_FIXED_BITS);
    let to_border = min(texel, v.grid.size.xy - 1 - texel);
    return min(to_border.x, to_border.y);
}

// Selects the file whose grid holds a point farthest inside.
fn adumbra_select_best(count: u32, p_world: vec3f) {
    var best = 0u;
    var best_texels = -0x7fffffff;
    for (var file = 0u; file < count; file++) {
        adumbra_select_file(file);
        let texels = adumbra_texels_inside(p_world);
        if (texels > best_texels) {
            best = file;
            best_texels = texels;
        }
        if (texels >= ADUMBRA_FAR_INSIDE) {
            break;
        }
    }
    adumbra_select_file(best);
}

// Returns the visibility of a point, 1 if no file is in use. `normal` is the unit normal of the surface, or
// zero in the air; `pixel` varies the noise of penumbrae.
fn adumbra_visibility(p_world: vec3f, normal: vec3f, pixel: vec2f) -> f32 {
    let count = adumbra_file_count();
    if (count == 0u) {
        return 1.0;
    }
    if (count == 1u) {
        adumbra_select_file(0u);
    } else {
        adumbra_select_best(count, p_world);
    }
    let s = adumbra_surface_at(p_world, normal, pixel);
    // Where a page is not resident, a coarser level answers. While a page fades in or out, a coarser level
    // has a share.
    var blend = vec2f(0.0, 1.0);
    loop {
        let v = adumbra_texture_params();
        blend = adumbra_blend(blend, v, s, adumbra_look_up(v, s));
        if (blend.y <= 0.0 || !adumbra_coarser_level()) {
            break;
        }
    }
    return blend.x;
}
