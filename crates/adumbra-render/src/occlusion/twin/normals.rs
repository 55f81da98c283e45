//! Normals computed from depth, on the CPU.

use adumbra_shaders::layout::OcclusionParams;

use super::filter::along;
use super::{Surfaces, index, ndc, texels};

const ONE_PIXEL: f32 = 4.0;
const NO_PIXEL: f32 = 8.0;

pub(super) fn normals(params: &OcclusionParams, surfaces: &Surfaces<'_>) -> Vec<[f32; 3]> {
    let pixels = surfaces.frame.size;
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
    let (scale, view) = (params.pixels_per_texel, &params.view);
    texels(params.size)
        .map(|texel| {
            let pixel = texel.map(|c| c * scale as i32);
            let own = depth_at(pixel);
            if own == 0.0 {
                return [0.0; 3];
            }
            let steps = [step_along(pixel, [1, 0], own), step_along(pixel, [0, 1], own)];
            let per_ndc = [0, 1].map(|a| steps[a] * scale as f32 / view.ndc_per_texel[a]);
            let ndc = ndc(view, texel);
            let half_view = [0, 1].map(|a| view.half_view[a] + view.half_view_per_depth[a]);
            let n = if params.depth_to_z.is_perspective() {
                let middle = own - (ndc[0] * per_ndc[0] + ndc[1] * per_ndc[1]);
                [-per_ndc[0] / half_view[0], -per_ndc[1] / half_view[1], -middle]
            } else {
                let slope = params.depth_to_z.numerator_slope;
                [slope * per_ndc[0] / half_view[0], slope * per_ndc[1] / half_view[1], -1.0]
            };
            let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
            let n = n.map(|c| c / length);
            [0, 1, 2].map(|a| n[0] * view.right[a] + n[1] * view.up[a] + n[2] * view.forward[a])
        })
        .collect()
}
