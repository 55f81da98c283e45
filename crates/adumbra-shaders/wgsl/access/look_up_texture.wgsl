// Words of the look-up texture, version 3: the counterpart of adumbra::gpu::LookUpTexture. Source:
// spec/look-up-texture.md. Texels are fetched by `adumbra_texture_texel` of access/texture_r32uint.wgsl or
// access/texture_rgba8unorm.wgsl. An engine that has the texels elsewhere provides the two functions of those
// files itself.

// Number of header words before those of the file.
const ADUMBRA_TEXTURE_HEADER: u32 = 128u;

fn adumbra_texture_word(word: u32) -> u32 {
    let width = adumbra_texture_width();
    return adumbra_texture_texel(vec2u(word & (width - 1u), word >> firstTrailingBit(width)));
}

// First word of the header in use. A streamed file has one for each level, the finest first.
var<private> adumbra_texture_header: u32;

fn adumbra_header_word(word: u32) -> u32 {
    return adumbra_texture_word(adumbra_texture_header + word);
}

// Returns to the header of the finest level.
fn adumbra_finest_level() {
    adumbra_texture_header = 0u;
}

// Advances to the header of the next coarser level. Returns whether there is one.
fn adumbra_coarser_level() -> bool {
    if (adumbra_header_word(7u) == 0u) {
        return false;
    }
    adumbra_texture_header += ADUMBRA_TEXTURE_HEADER;
    return true;
}

fn adumbra_voxel_word(index: u32) -> u32 {
    return adumbra_texture_word(ADUMBRA_TEXTURE_HEADER + index);
}
