// Words of the shadow files of one light, for web pages. They are those of the look-up texture
// (spec/look-up-texture.md) in two textures, so that a change of filter or bias writes a few hundred bytes:
//
// | texture | texel |
// |---|---|
// | adumbra_words | a word of the files, one file after the other, from left to right and row by row. The width is a power of two |
// | adumbra_headers | column w of row f is word w of the header of file f |
//
// Headers have three more words:
//
// | word | type | meaning |
// |---|---|---|
// | 104 | u32 | the file's first word in adumbra_words |
// | 105 | u32 | in row 0, the number of files in use; 0 lights everything |
// | 106 | u32 | the row of the header of the next coarser level, if the file is streamed; 0 if there is none |
//
// Worked value: the second of two files, the first of which has 32,000 words, has 32000 in word 104.

@group(0) @binding(0) var adumbra_words: texture_2d<u32>;
@group(0) @binding(1) var adumbra_headers: texture_2d<u32>;

const ADUMBRA_FIRST_WORD: u32 = 104u;
const ADUMBRA_FILE_COUNT: u32 = 105u;
const ADUMBRA_COARSER: u32 = 106u;

// Row of the selected file, or of a level of it.
var<private> adumbra_file: u32;
// The selected file's first word.
var<private> adumbra_first_word: u32;

fn adumbra_header_word(word: u32) -> u32 {
    return textureLoad(adumbra_headers, vec2u(word, adumbra_file), 0).x;
}

fn adumbra_voxel_word(index: u32) -> u32 {
    let word = adumbra_first_word + index;
    let width = textureDimensions(adumbra_words).x;
    return textureLoad(adumbra_words, vec2u(word & (width - 1u), word >> firstTrailingBit(width)), 0).x;
}

fn adumbra_file_count() -> u32 {
    return textureLoad(adumbra_headers, vec2u(ADUMBRA_FILE_COUNT, 0u), 0).x;
}

fn adumbra_select_file(file: u32) {
    adumbra_file = file;
    adumbra_first_word = adumbra_header_word(ADUMBRA_FIRST_WORD);
}

// Goes on to the header of the next coarser level. Returns whether there is one.
fn adumbra_coarser_level() -> bool {
    let row = adumbra_header_word(ADUMBRA_COARSER);
    if (row == 0u) {
        return false;
    }
    adumbra_select_file(row);
    return true;
}
