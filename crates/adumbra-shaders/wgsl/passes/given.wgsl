// The technique that reads precomputed factors, one per pixel: ray-traced truth, composited like any other
// technique. Do not use it with lists of points, which have no pixels.

@group(1) @binding(0) var given_factors: texture_2d<f32>;

fn adumbra_shadow_factor(s: AdumbraSurface) -> f32 {
    return textureLoad(given_factors, s.pixel, 0).x;
}
