// Returns the visibility of a point for a sun between those of two keys, the selected file and the other one:
// of one ray, or the mean of 3 × 3 rays half a filter apart. A ray without an answer in the first key is
// marched through the other key.
fn visibility(p_world: vec3<f32>, normal: vec3<f32>, towards_sun: vec3<f32>, pixel: vec2<f32>) -> f32 {
    adumbra_finest_level();
    let v = adumbra_texture_params();
    let s = surface_at(p_world, normal, towards_sun, pixel);
    let slope = words::slope();
    let apart = i32(v.filter_width >> 1u);
    let taps = select(9, 1, apart == 0);
    var lit = 0u;
    var unknown = 0u;
    for (var tap = 0; tap < taps; tap++) {
        let marched = adumbra_march(v, slope, adumbra_march_start(v, slope, s, tap_at(apart, tap)));
        lit += u32(marched == ADUMBRA_MARCH_CLEAR);
        unknown |= u32(marched >= ADUMBRA_MARCH_UNKNOWN) << u32(tap);
    }
    if (unknown != 0u) {
        lit += lit_in_other(unknown, apart, taps, p_world, normal, towards_sun);
    }
    return f32(lit) / f32(taps);
}

// Returns how many of some rays are lit in the other key.
fn lit_in_other(
    rays: u32,
    apart: i32,
    taps: i32,
    p_world: vec3<f32>,
    normal: vec3<f32>,
    towards_sun: vec3<f32>,
) -> u32 {
    words::select_other();
    let v = adumbra_texture_params();
    let s = surface_at(p_world, normal, towards_sun, vec2<f32>(0.0));
    let slope = words::slope();
    var lit = 0u;
    for (var tap = 0; tap < taps; tap++) {
        if (((rays >> u32(tap)) & 1u) == 1u) {
            let start = adumbra_march_start(v, slope, s, tap_at(apart, tap));
            lit += u32(adumbra_march(v, slope, start) != ADUMBRA_MARCH_BLOCKED);
        }
    }
    return lit;
}

fn tap_at(apart: i32, tap: i32) -> vec2<i32> {
    return apart * (vec2<i32>(tap % 3, tap / 3) - 1);
}
