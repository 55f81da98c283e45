//! From a frame's camera to that of the frame before, for the mean over frames.

use adumbra_shaders::layout::{Frame, OcclusionHistoryParams};

use super::settings::OcclusionSettings;

/// How far off a point's plane its own surface may have been, of half of what is seen at its depth: what interpolation and
/// rounding come to, and little beside things worth seeing.
const TOLERANCE: f32 = 0.002;

impl OcclusionSettings {
    /// The uniform of the mean over frames; `before` none where nothing is known of a frame before.
    pub fn history_params(&self, now: &Frame, before: Option<&Frame>) -> OcclusionHistoryParams {
        let old = before.unwrap_or(now);
        let (to, from) = (self.params(old), self.params(now));
        let anchor = |f: &Frame, a: usize| f64::from(f.anchor_world[a]) + f64::from(f.anchor_rest[a]);
        let moved: [f64; 3] = std::array::from_fn(|a| anchor(now, a) - anchor(old, a));
        let dot = |a: [f32; 4], b: [f64; 3]| (0..3).map(|i| f64::from(a[i]) * b[i]).sum::<f64>() as f32;
        let wide = |a: [f32; 4]| [0, 1, 2].map(|i| f64::from(a[i]));
        let row = |axis: [f32; 4]| {
            let [x, y, z] = [from.right, from.up, from.forward].map(|a| dot(axis, wide(a)));
            [x, y, z, dot(axis, moved)]
        };
        OcclusionHistoryParams {
            before_x: row(to.right),
            before_y: row(to.up),
            before_z: row(to.forward),
            ndc_from_texel: to.ndc_from_texel,
            half_view: to.half_view,
            right: to.right,
            up: to.up,
            forward: to.forward,
            limits: [
                TOLERANCE * to.half_view[1],
                TOLERANCE * to.half_view[3],
                self.frames as f32,
                if before.is_some() { 1.0 } else { 0.0 },
            ],
        }
    }
}
