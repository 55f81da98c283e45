//! Normals from depth.

use adumbra_shaders::layout::OcclusionParams;

use super::filter::along;
use super::{Surfaces, index, texels};

const ONE_PIXEL: f32 = 4.0;
const NO_PIXEL: f32 = 8.0;

pub(super) fn normals(params: &OcclusionParams, surfaces: &Surfaces<'_>) -> Vec<[f32; 3]> {
    let pixels = [surfaces.frame.size[0], surfaces.frame.size[1]];
    let depth_at = |pixel| index(pixels, pixel).map_or(0.0, |i| surfaces.depth[i]);
    let side_of = |pixel, axis: [i32; 2], side: i32, own: f32| {
        let [one, two] = [1, 2].map(|i| depth_at(along(pixel, axis, i * side)));
        let miss = if two == 0.0 { ONE_PIXEL } else { (2.0 * one - two - own).abs() };
        if one == 0.0 { [0.0, NO_PIXEL] } else { [one - own, miss] }
    };
    let step_along = |pixel, axis, own| {
        let (before, after) = (side_of(pixel, axis, -1, own), side_of(pixel, axis, 1, own));
        if before[1] < after[1] { -before[0] } else { after[0] }
    };
    let (scale, ndc_from_texel) = (params.size[2], params.ndc_from_texel);
    texels([params.size[0], params.size[1]])
        .map(|texel| {
            let pixel = texel.map(|c| c * scale as i32);
            let own = depth_at(pixel);
            if own == 0.0 {
                return [0.0; 3];
            }
            let steps = [step_along(pixel, [1, 0], own), step_along(pixel, [0, 1], own)];
            let per_ndc = [0, 1].map(|a| steps[a] * scale as f32 / ndc_from_texel[a]);
            let ndc = [0, 1].map(|a| ndc_from_texel[a] * texel[a] as f32 + ndc_from_texel[a + 2]);
            let half_view = [0, 1].map(|a| params.half_view[a] + params.half_view[a + 2]);
            let k = params.depth_to_z;
            let n = if k[3] != 0.0 {
                let middle = own - (ndc[0] * per_ndc[0] + ndc[1] * per_ndc[1]);
                [-per_ndc[0] / half_view[0], -per_ndc[1] / half_view[1], -middle]
            } else {
                [k[1] * per_ndc[0] / half_view[0], k[1] * per_ndc[1] / half_view[1], -1.0]
            };
            let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
            let n = n.map(|c| c / length);
            let world = |a: usize| n[0] * params.right[a] + n[1] * params.up[a] + n[2] * params.forward[a];
            [0, 1, 2].map(|a| as_half(world(a)))
        })
        .collect()
}

/// As 16 bits hold a number of at most 1.
fn as_half(value: f32) -> f32 {
    // The 11 bits of a half float stand 13 above the last of a float; below its least exponent its steps no longer shrink.
    let exponent = ((value.to_bits() >> 23 & 255) as i32 - 127).max(-14);
    let step = 2.0_f32.powi(exponent - 10);
    (value / step).round_ties_even() * step
}

#[cfg(test)]
mod tests {
    use super::as_half;

    #[test]
    fn halves_are_rounded_to_the_nearest() {
        for (value, half) in
            [(1.0, 1.0), (0.333_333_34, 0.333_251_95), (-0.1, -0.099_975_586), (0.0, 0.0), (1e-8, 0.0)]
        {
            assert_eq!(as_half(value), half);
        }
    }
}
