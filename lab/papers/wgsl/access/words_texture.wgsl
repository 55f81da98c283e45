// Words of a tree from the pages of an RGBA8 texture, one page per layer, laid out as
// adumbra_papers::tree::texture::Layout defines. R holds bits 7 to 0 of a word, and so on up to A with bits
// 31 to 24. The last row of a page is its signature and holds no words. Source: The Optimization and
// realization of Compact Precomputed Voxelized Shadows Algorithm, 2021, §3.3.2.

@group(1) @binding(1) var adumbra_voxel_pages: texture_2d_array<u32>;

fn adumbra_voxel_word(index: u32) -> u32 {
    let size = textureDimensions(adumbra_voxel_pages);
    let row = index >> firstTrailingBit(size.x);
    let rows = size.y - 1u;
    let page = row / rows;
    let texel = textureLoad(adumbra_voxel_pages, vec2u(index & (size.x - 1u), row - page * rows), page, 0);
    return texel.x | texel.y << 8u | texel.z << 16u | texel.w << 24u;
}
