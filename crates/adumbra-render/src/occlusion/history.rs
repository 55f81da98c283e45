//! Transforms from a frame's camera to the previous frame's, for the mean over frames.

use adumbra_shaders::layout::{Frame, OcclusionHistoryParams};

use super::settings::OcclusionSettings;

/// Distance from a point's plane up to which its surface in the previous frame counts in full, as a share of
/// half the view's height at its depth. It covers interpolation and rounding errors, and is small compared
/// with visible detail.
const TOLERANCE: f32 = 0.002;

impl OcclusionSettings {
    /// Returns the uniform of the mean over frames. `before` is `None` if there is no previous frame.
    pub(crate) fn history_params(&self, now: &Frame, before: Option<&Frame>) -> OcclusionHistoryParams {
        let old = before.unwrap_or(now);
        let (to, from) = (self.params(old), self.params(now));
        let anchor = |f: &Frame, a: usize| f64::from(f.anchor_world[a]) + f64::from(f.anchor_rest_world[a]);
        let moved: [f64; 3] = std::array::from_fn(|a| anchor(now, a) - anchor(old, a));
        let dot = |a: [f32; 3], b: [f64; 3]| (0..3).map(|i| f64::from(a[i]) * b[i]).sum::<f64>() as f32;
        let double = |a: [f32; 3]| a.map(f64::from);
        let (to_view, from_view) = (to.view, from.view);
        let row = |axis: [f32; 3]| {
            let [x, y, z] = [from_view.right, from_view.up, from_view.forward].map(|a| dot(axis, double(a)));
            [x, y, z, dot(axis, moved)]
        };
        OcclusionHistoryParams {
            x_from_now: row(to_view.right),
            y_from_now: row(to_view.up),
            z_from_now: row(to_view.forward),
            view: to_view,
            tolerance_world: TOLERANCE * to_view.half_view[1],
            tolerance_world_per_depth: TOLERANCE * to_view.half_view_per_depth[1],
            max_frames: self.frames as f32,
            has_before: before.is_some().into(),
        }
    }
}
