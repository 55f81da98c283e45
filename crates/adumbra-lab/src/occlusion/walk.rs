//! Flicker along a camera path, of estimators on a device and of the truth.

use adumbra::camera::Camera;
use adumbra_render::occlusion::OcclusionPasses;

use super::flicker::{Flicker, FlickerCount, FlickerFrame};
use super::measure::{OcclusionJudge, OcclusionStage};
use crate::error::Result;

/// What every picture of a frame is seen on.
struct Frame {
    camera: Camera,
    view_depth: Vec<f64>,
    normal: Vec<[f32; 3]>,
}

impl Frame {
    fn with<'a>(&'a self, visibility: &'a [f32]) -> FlickerFrame<'a> {
        FlickerFrame { camera: self.camera, view_depth: &self.view_depth, normal: &self.normal, visibility }
    }
}

/// Each of `passes` at every camera in turn, frame k of all before frame k + 1 of any; one figure each, none where no
/// pixel was counted. The stage is left at the last camera.
///
/// # Errors
/// What the renderer reports.
pub fn path_flicker(
    stage: &mut OcclusionStage,
    cameras: &[Camera],
    passes: &mut [OcclusionPasses],
) -> Result<Vec<Option<Flicker>>> {
    let mut counts = vec![FlickerCount::default(); passes.len()];
    let mut before: Option<(Frame, Vec<Vec<f32>>)> = None;
    for (number, camera) in (0..).zip(cameras) {
        stage.look(*camera, number)?;
        let drawn = stage.surface()?;
        let view_depth = drawn.view_depth.into_iter().map(f64::from).collect();
        let frame = Frame { camera: *camera, view_depth, normal: drawn.normal };
        let visibility = passes.iter_mut().map(|p| stage.visibility(p)).collect::<Result<Vec<Vec<f32>>>>()?;
        if let Some((old, pictures)) = &before {
            for (i, count) in counts.iter_mut().enumerate() {
                count.add(&old.with(&pictures[i]), &frame.with(&visibility[i]))?;
            }
        }
        before = Some((frame, visibility));
    }
    Ok(counts.iter().map(FlickerCount::finish).collect())
}

/// The truth's own: what resampling leaves of it, and the noise of its rays.
///
/// # Errors
/// None but those of [`FlickerCount::add`]. Cost: a truth a camera, where it is not kept yet.
pub fn truth_flicker(judge: &OcclusionJudge<'_, '_>, cameras: &[Camera]) -> Result<Option<Flicker>> {
    let mut count = FlickerCount::default();
    let mut before: Option<(Frame, Vec<f32>)> = None;
    for camera in cameras {
        let (surfaces, truth) = judge.trace(camera);
        let frame = Frame { camera: *camera, view_depth: surfaces.view_depth, normal: surfaces.normal };
        if let Some((old, picture)) = &before {
            count.add(&old.with(picture), &frame.with(&truth))?;
        }
        before = Some((frame, truth));
    }
    Ok(count.finish())
}
