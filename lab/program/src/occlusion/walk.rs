//! Flicker along a camera path, of estimators on a device and of the truth.

use adumbra_render::occlusion::OcclusionPasses;
use adumbra_scene::Camera;

use super::flicker::{Flicker, FlickerCount, FlickerFrame};
use super::measure::{OcclusionReference, OcclusionStage};
use adumbra_compare::error::Result;

/// Camera and surfaces common to all pictures of a frame.
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

/// Measures the flicker of each of `passes` along the path of `cameras`: frame k of all before frame k + 1 of
/// any.
///
/// Returns one result per pass, `None` if no pixel was counted. The stage is left at the last camera.
///
/// # Errors
/// Returns the errors of the renderer.
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

/// Measures the truth's own flicker, which is due to resampling and to the noise of its rays.
///
/// Cost: one truth per camera, if it is not cached yet.
///
/// # Errors
/// Returns the errors of [`FlickerCount::add`].
pub(crate) fn truth_flicker(
    reference: &OcclusionReference<'_, '_>,
    cameras: &[Camera],
) -> Result<Option<Flicker>> {
    let mut count = FlickerCount::default();
    let mut before: Option<(Frame, Vec<f32>)> = None;
    for camera in cameras {
        let (surfaces, truth) = reference.trace(camera);
        let frame = Frame { camera: *camera, view_depth: surfaces.view_depth, normal: surfaces.normal };
        if let Some((old, picture)) = &before {
            count.add(&old.with(picture), &frame.with(&truth))?;
        }
        before = Some((frame, truth));
    }
    Ok(count.finish())
}
