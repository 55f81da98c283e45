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
            [0, 1, 2].map(|a| n[0] * params.right[a] + n[1] * params.up[a] + n[2] * params.forward[a])
        })
        .collect()
}
