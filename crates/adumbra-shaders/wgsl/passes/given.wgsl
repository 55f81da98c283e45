// Factors made elsewhere, one a pixel: the truth, composited like every other technique. Lists of points have no pixels, so they are
// not to be asked of it.

@group(1) @binding(0) var given_factors: texture_2d<f32>;

fn shadow_factor(s: Surface) -> f32 {
    return textureLoad(given_factors, s.pixel, 0).x;
}
