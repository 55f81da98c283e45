// Texels of a look-up texture of format R32Uint: each is one word.

@group(1) @binding(0) var adumbra_look_up: texture_2d<u32>;

fn adumbra_texture_width() -> u32 {
    return textureDimensions(adumbra_look_up).x;
}

fn adumbra_texture_texel(texel: vec2u) -> u32 {
    return textureLoad(adumbra_look_up, texel, 0).x;
}
