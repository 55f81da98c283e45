// Texels of a look-up texture of format Rgba8Unorm: R is bits 7 to 0 of the word, …, A is bits 31 to 24.

@group(1) @binding(0) var adumbra_look_up: texture_2d<f32>;

fn adumbra_texture_width() -> u32 {
    return textureDimensions(adumbra_look_up).x;
}

fn adumbra_texture_texel(texel: vec2u) -> u32 {
    return pack4x8unorm(textureLoad(adumbra_look_up, texel, 0));
}
