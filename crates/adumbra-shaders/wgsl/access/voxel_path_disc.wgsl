// The look-up for a sun between those of two keys, as a disc: rays to 32 points of the disc.
// access/voxel_path.wgsl and core/disc.wgsl must precede this file. Source: spec/sun-path.md.

// Returns the visible share of the sun's disc.
fn adumbra_file_factor(s: AdumbraSurface) -> f32 {
    let turn = adumbra_disc_turn(s.pixel);
    var lit = 0u;
    for (var i = 0u; i < 32u; i++) {
        lit += u32(adumbra_path_is_lit(s, vec2i(0), adumbra_disc_tap(i, turn)));
    }
    return f32(lit) / 32.0;
}
