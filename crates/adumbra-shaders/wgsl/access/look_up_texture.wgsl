// Words of the look-up texture, version 2: the counterpart of adumbra::gpu::LookUpTexture. Source:
// spec/look-up-texture.md. Texels are fetched by `adumbra_texture_texel` of access/texture_r32uint.wgsl or
// access/texture_rgba8unorm.wgsl. An engine with different bindings provides the two functions of those files itself.

// Number of header words before those of the file.
const ADUMBRA_TEXTURE_HEADER: u32 = 128u;

fn adumbra_texture_word(word: u32) -> u32 {
    let width = adumbra_texture_width();
    return adumbra_texture_texel(vec2u(word & (width - 1u), word >> firstTrailingBit(width)));
}

fn adumbra_voxel_word(index: u32) -> u32 {
    return adumbra_texture_word(ADUMBRA_TEXTURE_HEADER + index);
}
