// The visibility for the sun of a moment, from two keys of a sun path (spec/sun-path.md). surface.wgsl comes
// before this text, main.wgsl after it. Both keys, and all words that change with the moment, are in one
// texture:
//
// | words of adumbra_words | content |
// |---|---|
// | 0 to 127, 128 to 255 | the header of the key that is looked up first, and of the other one, which may be the same key |
// | from a row of texels on | the words of a key; those of the other key begin at another row |
//
// Headers are those of the look-up texture (spec/look-up-texture.md), with more words:
//
// | word | type | meaning |
// |---|---|---|
// | 104 | u32 | the key's first word in adumbra_words |
// | 106 | u32 | of the first header: 1 at night, when every point is in shadow; else 0 |
// | 107 | 2 × i32 | sideways texels per voxel towards the sun, in 2^-16 |
// | 109 | u32 | of the first header: for how many voxels a ray must be hidden from both keys to be taken to meet something, 0 = never |
//
// Word 105 of adumbra_headers is 0 while the light does not shine from the sun of the moment.

@group(0) @binding(0) var adumbra_words: texture_2d<u32>;
@group(0) @binding(1) var adumbra_headers: texture_2d<u32>;

const ADUMBRA_FIRST_WORD: u32 = 104u;
const ADUMBRA_FILE_COUNT: u32 = 105u;
const ADUMBRA_IS_NIGHT: u32 = 106u;
const ADUMBRA_SLOPE: u32 = 107u;
const ADUMBRA_DARK_AFTER: u32 = 109u;

// First word of the selected key's header.
var<private> adumbra_key_header: u32;
// The selected key's first word.
var<private> adumbra_first_word: u32;
// For each ray without an answer in the first key: the result of its march.
var<private> adumbra_unknown: array<u32, 9>;

fn adumbra_word(index: u32) -> u32 {
    let width = textureDimensions(adumbra_words).x;
    return textureLoad(adumbra_words, vec2u(index & (width - 1u), index >> firstTrailingBit(width)), 0).x;
}

fn adumbra_header_word(word: u32) -> u32 {
    return adumbra_word(adumbra_key_header + word);
}

fn adumbra_voxel_word(index: u32) -> u32 {
    return adumbra_word(adumbra_first_word + index);
}

fn adumbra_select_key(key: u32) {
    adumbra_key_header = 128u * key;
    adumbra_first_word = adumbra_header_word(ADUMBRA_FIRST_WORD);
}

// Marches some rays of the filter, one bit each, through a key. Returns the rays that are dark, and, for the
// first key, the rays without an answer.
fn adumbra_march_taps(key: u32, taps: u32, p_world: vec3f, normal: vec3f, pixel: vec2f) -> vec2u {
    let dark_after = adumbra_header_word(ADUMBRA_DARK_AFTER);
    adumbra_select_key(key);
    let v = adumbra_texture_params();
    let s = adumbra_surface_at(p_world, normal, pixel);
    let slope = vec2i(vec2u(adumbra_header_word(ADUMBRA_SLOPE), adumbra_header_word(ADUMBRA_SLOPE + 1u)));
    let apart = i32(v.filter_width >> 1u);
    var found = vec2u(0u);
    for (var tap = 0u; (taps >> tap) != 0u; tap++) {
        if (((taps >> tap) & 1u) == 0u) {
            continue;
        }
        let aside = apart * (vec2i(i32(tap % 3u), i32(tap / 3u)) - 1);
        let marched = adumbra_march(v, slope, adumbra_march_start(v, slope, s, aside));
        var is_dark = marched == ADUMBRA_MARCH_BLOCKED;
        if (marched >= ADUMBRA_MARCH_UNKNOWN) {
            if (key == 0u) {
                adumbra_unknown[tap] = marched;
                found.y |= 1u << tap;
            } else {
                is_dark = adumbra_march_is_guessed_dark(adumbra_unknown[tap], marched, dark_after);
            }
        }
        found.x |= u32(is_dark) << tap;
    }
    return found;
}

// Returns the visibility of a point: of one ray, or the mean of 3 × 3 rays half a filter apart; 1 if no file
// is in use. `normal` is the unit normal of the surface, or zero in the air.
fn adumbra_visibility(p_world: vec3f, normal: vec3f, pixel: vec2f) -> f32 {
    if (textureLoad(adumbra_headers, vec2u(ADUMBRA_FILE_COUNT, 0u), 0).x == 0u) {
        return 1.0;
    }
    adumbra_select_key(0u);
    if (adumbra_header_word(ADUMBRA_IS_NIGHT) != 0u) {
        return 0.0;
    }
    let count = select(9u, 1u, adumbra_texture_params().filter_width == 1u);
    let first = adumbra_march_taps(0u, (1u << count) - 1u, p_world, normal, pixel);
    var dark = first.x;
    if (first.y != 0u) {
        dark |= adumbra_march_taps(1u, first.y, p_world, normal, pixel).x;
    }
    return f32(count - countOneBits(dark)) / f32(count);
}
