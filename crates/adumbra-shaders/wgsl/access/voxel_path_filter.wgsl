// The look-up for a sun between those of two keys, with a filter. access/voxel_path.wgsl must precede this
// file. Source: spec/sun-path.md.

// Returns the visibility of one ray, or the mean of 3 × 3 rays half a filter apart.
fn adumbra_file_factor(s: AdumbraSurface) -> f32 {
    if (adumbra_path.ways[0].z == 1) {
        let own = vec2f(adumbra_voxel_factor(adumbra_path.keys[0], s), adumbra_voxel_factor(adumbra_path.keys[1], s));
        if (own.x == own.y && (own.x == 0.0 || own.x == 1.0)) {
            return own.x;
        }
    }
    let apart = i32(adumbra_path.keys[0].filter_width >> 1u);
    if (apart == 0) {
        return select(0.0, 1.0, adumbra_path_is_lit(s, vec2i(0), vec2f(0.0)));
    }
    var lit = 0u;
    for (var tap = 0; tap < 9; tap++) {
        lit += u32(adumbra_path_is_lit(s, apart * (vec2i(tap % 3, tap / 3) - 1), vec2f(0.0)));
    }
    return f32(lit) / 9.0;
}
