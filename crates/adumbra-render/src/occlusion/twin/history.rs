//! The mean over previous frames on the CPU.

use adumbra_shaders::layout::Frame;

use super::{Ambient, Surfaces, direction, dot, index, made_normals, point_at, texel_of, texels};
use crate::occlusion::settings::OcclusionSettings;

/// Visibility, view depth, number of frames.
pub(super) type HistoryTexel = [f32; 3];

const WHOLE_WEIGHT: f32 = 0.25;

pub(super) fn mean(
    settings: &OcclusionSettings,
    surfaces: &Surfaces<'_>,
    estimate: &[Ambient],
    before: Option<&(Frame, Vec<HistoryTexel>)>,
) -> Vec<HistoryTexel> {
    let frame = &surfaces.frame;
    let before = before.filter(|(old, _)| old.size == frame.size);
    let history = settings.history_params(frame, before.map(|(old, _)| old));
    let now = settings.params(frame);
    let size = now.size;
    let made = made_normals(settings, surfaces);
    let normals = made.as_deref().unwrap_or(surfaces.normal);
    let normals_width = if made.is_some() { now.size[0] } else { frame.size[0] };
    let seen_before = |texel: [i32; 2], z: f32| -> Option<[f32; 2]> {
        let (_, old) = before?;
        let p = point_at(&now.view, texel, z);
        let carried = |row: [f32; 4]| dot([row[0], row[1], row[2]], p) + row[3];
        let p = [carried(history.x_from_now), carried(history.y_from_now), carried(history.z_from_now)];
        let at = texel_of(&history.view, p);
        if p[2] <= 0.0 || at.iter().any(|c| c.abs() > 65536.0) {
            return None;
        }
        let [x, y] = texel.map(|c| c as u32 * now.pixels_per_normal);
        let n_world = normals[(y * normals_width + x) as usize];
        let n = direction(&history.view, n_world);
        let limit = history.tolerance_world + history.tolerance_world_per_depth * p[2];
        let first = at.map(f32::floor);
        let (mut sum, mut weights) = ([0.0; 2], 0.0);
        for step in [[0, 0], [1, 0], [0, 1], [1, 1]] {
            let other = [0, 1].map(|a| first[a] as i32 + step[a]);
            let Some([visibility, old_z, frames]) = index(size, other).map(|i| old[i]) else { continue };
            let q = point_at(&history.view, other, old_z);
            if old_z <= 0.0 {
                continue;
            }
            let off = dot([0, 1, 2].map(|a| q[a] - p[a]), n).abs();
            let share = (2.0 - off / limit).clamp(0.0, 1.0);
            let near = [0, 1].map(|a| {
                let part = at[a] - first[a];
                if step[a] == 1 { part } else { 1.0 - part }
            });
            let weight = near[0] * near[1] * share;
            sum = [sum[0] + weight * visibility, sum[1] + weight * frames];
            weights += weight;
        }
        (weights > 0.0).then(|| [sum[0] / weights, sum[1] / weights.max(WHOLE_WEIGHT)])
    };
    texels(size)
        .zip(estimate)
        .map(|(texel, &[visibility, z])| match seen_before(texel, z) {
            _ if z <= 0.0 => [visibility, z, 0.0],
            Some([old, frames]) => {
                let frames = (frames + 1.0).min(settings.frames as f32);
                [old + (visibility - old) / frames, z, frames]
            }
            None => [visibility, z, 1.0],
        })
        .collect()
}
