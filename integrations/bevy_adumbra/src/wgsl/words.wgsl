// Fetches words of the files in use. They are rows of look-up textures (spec/look-up-texture.md), one file
// after the other, at the bottom of the texture that a view binds for transmission. A last row lists them,
// the directory:
//
// | words | meaning |
// |---|---|
// | 0 | MAGIC |
// | 1 | number of files, 1 to 8 |
// | 2 | number of rows, with the directory's |
// | 3, 4 | width and height of the picture above them, as Bevy copies it for transmission; 0 without one |
// | 8 + 8 i | first row of file i, counted from the first of these rows |
// | 9 + 8 i | log2 of its width in texels |
// | 10 + 8 i | how it is looked up: 0 with a filter, 1 with penumbrae, 2 by a march to a sun beside its own |
// | 11 + 8 i | 1 if no other file has this sun |
// | 12 + 8 i | sideways texels along x per voxel towards that sun, in 2^-16; 0 without a march |
// | 13 + 8 i | the same along y |
// | 14 + 8 i | the file that is looked up where the march through this one has no answer; 0 without a march |
//
// Worked value: one file of 256 × 126 texels with penumbrae has the words MAGIC, 1, 127, and from word 8 on
// 0, 8, 1, 1.
#define_import_path adumbra::words
#import bevy_pbr::mesh_view_bindings as view_bindings

const MAGIC: u32 = 0x44554441u;

// How a byte b of a word is stored: as b / 255, as b, or as an sRGB colour.
const UNORM: u32 = 0u;
const NUMBERS: u32 = 1u;
const SRGB: u32 = 2u;

var<private> encoding: u32;
// Rows of the texture: the first one with words, the directory, and the first one of the selected file.
var<private> first_row: u32;
var<private> directory_row: u32;
var<private> file_row: u32;
var<private> file_width_log2: u32;
var<private> file_index: u32;

fn srgb(linear: vec3<f32>) -> vec3<f32> {
    let dark = 12.92 * linear;
    let bright = 1.055 * pow(linear, vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(bright, dark, linear <= vec3<f32>(0.0031308));
}

fn load(texel: vec2<u32>) -> u32 {
    let bytes = textureLoad(view_bindings::view_transmission_texture, texel, 0);
    if (encoding == NUMBERS) {
        return pack4x8unorm(bytes / 255.0);
    }
    if (encoding == SRGB) {
        return pack4x8unorm(vec4<f32>(srgb(bytes.rgb), bytes.a));
    }
    return pack4x8unorm(bytes);
}

fn directory(word: u32) -> u32 {
    return load(vec2<u32>(word, directory_row));
}

// Finds the directory. Returns whether there is one.
fn find_directory() -> bool {
    let height = textureDimensions(view_bindings::view_transmission_texture).y;
    directory_row = height - 1u;
    encoding = UNORM;
    if (directory(0u) != MAGIC) {
        encoding = NUMBERS;
        if (directory(0u) != MAGIC) {
            encoding = SRGB;
            if (directory(0u) != MAGIC) {
                return false;
            }
        }
    }
    first_row = height - directory(2u);
    return true;
}

// Finds the directory. Returns the number of files, 0 in a view without any.
fn open() -> u32 {
    if (find_directory()) {
        return directory(1u);
    }
    return 0u;
}

// Size of the picture that is seen through glass, in texels; 0 where there is none.
var<private> picture: vec2<f32>;

// Finds the picture. Call it once per point of glass. Returns the picture's size, 1 if there is none.
fn picture_size() -> vec2<f32> {
    picture = vec2<f32>(textureDimensions(view_bindings::view_transmission_texture));
    if (find_directory()) {
        picture = vec2<f32>(vec2<u32>(directory(3u), directory(4u)));
    }
    return max(picture, vec2<f32>(1.0));
}

// Returns the colour seen through glass at a place of the picture, from 0 to 1 along each side; zero without
// a picture.
fn transmitted(place: vec2<f32>) -> vec4<f32> {
    if (picture.x == 0.0) {
        return vec4<f32>(0.0);
    }
    let at = clamp(place * picture, vec2<f32>(0.5), picture - 0.5)
        / vec2<f32>(textureDimensions(view_bindings::view_transmission_texture));
    return textureSampleLevel(view_bindings::view_transmission_texture, view_bindings::view_transmission_sampler, at, 0.0);
}

// Selects a file. Returns how it is looked up.
fn select_file(file: u32) -> u32 {
    file_index = file;
    file_row = first_row + directory(8u + 8u * file);
    file_width_log2 = directory(9u + 8u * file);
    return directory(10u + 8u * file);
}

fn is_alone(file: u32) -> bool {
    return directory(11u + 8u * file) == 1u;
}

// Returns the slope of a march through the selected file.
fn slope() -> vec2<i32> {
    return bitcast<vec2<i32>>(vec2<u32>(directory(12u + 8u * file_index), directory(13u + 8u * file_index)));
}

// Selects the file that is looked up where the march through the selected one has no answer.
fn select_other() {
    select_file(directory(14u + 8u * file_index));
}

// Returns the unit vector towards the selected file's sun.
fn towards_sun() -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3<u32>(texel(vec2<u32>(8u, 0u)), texel(vec2<u32>(9u, 0u)), texel(vec2<u32>(10u, 0u))));
}

// Returns the width of the selected file in texels.
fn width() -> u32 {
    return 1u << file_width_log2;
}

// Returns a texel of the selected file.
fn texel(at: vec2<u32>) -> u32 {
    return load(vec2<u32>(at.x, file_row + at.y));
}
