//! Upsampling from half size to the frame's size.

use super::filter::{along, run};
use super::{Ambient, Surfaces, index, texels, z_of};
use crate::occlusion::settings::OcclusionSettings;

const MIN_WEIGHT: f32 = 0.01;

pub(super) fn up(settings: &OcclusionSettings, surfaces: &Surfaces<'_>, from: &[Ambient]) -> Vec<Ambient> {
    let frame = &surfaces.frame;
    let pixels = frame.size;
    let size = settings.size(pixels);
    let params = settings.filter_params(frame, 0);
    let depth_at = |pixel| index(pixels, pixel).map_or(0.0, |i| z_of(frame.depth_to_z, surfaces.depth[i]));
    let run_along = |pixel, axis: [i32; 2], z: f32| {
        let [before, after] = [-1, 1].map(|side| depth_at(along(pixel, axis, side)));
        run(before, z, after, params.plane_kind, params.inverse_depth_width)
    };
    let visibility = |pixel: [i32; 2], z: f32| {
        let first = pixel.map(|c| c / 2);
        let odd = pixel.map(|c| c % 2);
        if odd == [0, 0] {
            return index(size, first).map_or(1.0, |i| from[i][0]);
        }
        let run_x = if odd[0] == 1 { run_along(pixel, [1, 0], z) } else { [0.0; 2] };
        let run_y = if odd[1] == 1 { run_along(pixel, [0, 1], z) } else { [0.0; 2] };
        let (mut sum, mut weights, mut nearest, mut smallest) = (0.0, 0.0, 1.0, f32::INFINITY);
        for y in first[1]..=first[1] + odd[1] {
            for x in first[0]..=first[0] + odd[0] {
                let Some([other, other_z]) = index(size, [x, y]).map(|i| from[i]) else { continue };
                if other_z <= 0.0 {
                    continue;
                }
                let offset = [2 * x - pixel[0], 2 * y - pixel[1]].map(|c| c as f32);
                let run = [0, 1].map(|a| offset[0] * run_x[a] + offset[1] * run_y[a]);
                let d = (other_z * (1.0 + run[0]) - (z + run[1])).abs();
                let k = d * params.inverse_depth_width;
                let weight = (-k * k).exp();
                sum += weight * other;
                weights += weight;
                if d < smallest {
                    (smallest, nearest) = (d, other);
                }
            }
        }
        if weights >= MIN_WEIGHT { sum / weights } else { nearest }
    };
    texels(pixels)
        .map(|pixel| {
            let z = depth_at(pixel);
            [if z > 0.0 { visibility(pixel, z) } else { 1.0 }, z]
        })
        .collect()
}
