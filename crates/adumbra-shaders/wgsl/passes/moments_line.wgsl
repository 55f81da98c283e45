// One axis of the Gaussian blur of a layer's moments. The passes along rows and along columns define
//     fn moments_at(texel: vec2i) -> vec4f      the moments to blur; beyond the border its texels repeat

@group(0) @binding(0) var<uniform> blur: AdumbraMomentBlurParams;
@group(0) @binding(2) var moments_out: AdumbraMomentsOut;

fn blur_moments(texel: vec2i, along: vec2i) {
    var sum = blur.weights[0].x * moments_at(texel);
    for (var i = 1; i <= i32(blur.taps_per_side); i++) {
        let weight = blur.weights[i / 4][i % 4];
        sum += weight * (moments_at(texel - i * along) + moments_at(texel + i * along));
    }
    textureStore(moments_out, texel, sum);
}
