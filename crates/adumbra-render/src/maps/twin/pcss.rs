//! Soft shadows from the distance of blockers. Twin of core/pcss.wgsl.

use adumbra_shaders::constants::POISSON_DISC;

use super::maps::Receiver;
use super::pcf::{DepthImage, turned};

/// Twin of `adumbra_pcss_blocker_distance`.
fn blocker_distance(
    image: &DepthImage<'_>,
    r: &Receiver,
    cone_texels: f32,
    max_radius: f32,
    turn: [f32; 2],
) -> Option<f32> {
    let search = (cone_texels * r.depth).clamp(1.0, max_radius);
    let (mut sum, mut count) = (0.0, 0.0);
    for &tap in &POISSON_DISC {
        let tap = turned(tap, turn);
        let spread = search * (tap[0] * tap[0] + tap[1] * tap[1]).sqrt();
        let offset = tap.map(|c| spread * c);
        let place = [r.p_texels[0] + offset[0], r.p_texels[1] + offset[1]];
        let [x, y] = place.map(|c| (c.floor() as i64).clamp(0, image.size - 1));
        let stored = image.at(x, y);
        let distance = r.depth - stored;
        let in_cone =
            (offset[0] * offset[0] + offset[1] * offset[1]).sqrt() <= (cone_texels * distance).max(1.0);
        if in_cone && r.plane_depth([x as f32 + 0.5, y as f32 + 0.5]) > stored {
            sum += distance.max(0.0);
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// Twin of `adumbra_pcss_visibility`.
pub(super) fn visibility(
    image: &DepthImage<'_>,
    r: &Receiver,
    cone_texels: f32,
    max_radius: f32,
    turn: [f32; 2],
) -> f32 {
    let Some(distance) = blocker_distance(image, r, cone_texels, max_radius, turn) else { return 1.0 };
    let radius = (cone_texels * distance).clamp(0.5, max_radius);
    image.disc(r, radius, 32, turn)
}
