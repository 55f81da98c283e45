// The visibility of a directional light from the files in use.
// `texels_inside_file` and `visibility_from_file`, which come before this text, call the modules of the ways
// in use.

// A file belongs to a light if the distance between the unit vectors to the sun and the light is at most
// this.
const SAME_SUN: f32 = 1.5e-3;
// A point at least this many texels inside a file's grid needs no better file.
const FAR_INSIDE: i32 = 8;
const NO_FILE: u32 = 0xffffffffu;

// Returns the visibility, or -1 if no file has this light's sun.
fn baked_visibility(towards_light: vec3<f32>, p_world: vec3<f32>, normal: vec3<f32>, pixel: vec2<f32>) -> f32 {
    let count = words::open();
    var best = NO_FILE;
    var best_texels = -0x7fffffff;
    for (var file = 0u; file < count; file++) {
        let kind = words::select_file(file);
        if (distance(words::towards_sun(), towards_light) > SAME_SUN) {
            continue;
        }
        if (words::is_alone(file)) {
            best = file;
            break;
        }
        let texels = texels_inside_file(kind, p_world, towards_light);
        if (texels > best_texels) {
            best = file;
            best_texels = texels;
        }
        if (texels >= FAR_INSIDE) {
            break;
        }
    }
    if (best == NO_FILE) {
        return -1.0;
    }
    let kind = words::select_file(best);
    return visibility_from_file(kind, p_world, normal, towards_light, pixel);
}

// Returns the visibility of a point from the files that have this directional light's sun; 1 if none has.
// `normal` is the unit normal of the surface, or zero in the air; `pixel` varies the noise of penumbrae.
fn sun_visibility(towards_light: vec3<f32>, p_world: vec3<f32>, normal: vec3<f32>, pixel: vec2<f32>) -> f32 {
    return abs(baked_visibility(towards_light, p_world, normal, pixel));
}

// Returns the visibility of a point in fog. `cascades` is the visibility from the light's cascades; the point
// is inside of them only if `is_inside`.
fn fog_visibility(cascades: f32, is_inside: bool, towards_light: vec3<f32>, p_world: vec3<f32>) -> f32 {
    let baked = baked_visibility(towards_light, p_world, vec3<f32>(0.0), vec2<f32>(0.0));
    if (baked < 0.0) {
        return cascades;
    }
    return min(select(1.0, cascades, is_inside), baked);
}
