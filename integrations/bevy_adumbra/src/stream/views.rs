//! Views of cameras.

use adumbra::stream::View;
use bevy::camera::Camera;
use bevy::camera::primitives::Frustum;
use bevy::transform::components::GlobalTransform;

/// Returns the view of a camera; `None` if the camera draws nothing.
pub(super) fn view(camera: &Camera, transform: &GlobalTransform, frustum: &Frustum) -> Option<View> {
    let height = camera.physical_viewport_size().map(|size| f64::from(size.y)).filter(|&y| y > 0.0)?;
    if !camera.is_active {
        return None;
    }
    let clip_from_view = camera.clip_from_view();
    // The picture is two units high in clip space: at a distance of 1 in a perspective, else at any distance.
    let pixel = 2.0 / (f64::from(clip_from_view.y_axis.y.abs()) * height);
    let is_parallel = clip_from_view.w_axis.w != 0.0;
    let [pixel_world, pixel_per_distance] = if is_parallel { [pixel, 0.0] } else { [0.0, pixel] };
    Some(View {
        position_world: transform.translation().to_array().map(f64::from),
        planes: frustum.half_spaces.map(|plane| plane.normal_d().to_array().map(f64::from)).to_vec(),
        pixel_world,
        pixel_per_distance,
    })
}

#[cfg(test)]
mod tests {
    use bevy::camera::{
        CameraProjection, ComputedCameraValues, OrthographicProjection, PerspectiveProjection,
        RenderTargetInfo, ScalingMode,
    };
    use bevy::math::{UVec2, Vec3};
    use bevy::prelude::Transform;

    use super::*;

    fn view_of(projection: &impl CameraProjection) -> View {
        let camera = Camera {
            computed: ComputedCameraValues {
                clip_from_view: projection.get_clip_from_view(),
                target_info: Some(RenderTargetInfo {
                    physical_size: UVec2::new(200, 100),
                    scale_factor: 1.0,
                }),
                ..Default::default()
            },
            ..Default::default()
        };
        let transform = Transform::from_xyz(1.0, 2.0, 3.0).looking_to(Vec3::X, Vec3::Y).into();
        view(&camera, &transform, &projection.compute_frustum(&transform)).expect("a view")
    }

    #[test]
    fn view_matches_the_camera_projection() {
        let fov = 50_f32;
        let found = view_of(&PerspectiveProjection {
            fov: fov.to_radians(),
            aspect_ratio: 2.0,
            ..Default::default()
        });
        let expected =
            View::perspective([1.0, 2.0, 3.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], fov.into(), [200, 100]);
        assert_eq!((found.position_world, found.pixel_world), (expected.position_world, 0.0));
        assert!((found.pixel_per_distance - expected.pixel_per_distance).abs() < 1e-6);
        let sees =
            |p: [f64; 3]| found.planes.iter().all(|n| n[0] * p[0] + n[1] * p[1] + n[2] * p[2] + n[3] >= 0.0);
        assert!(sees([11.0, 2.0, 3.0]) && sees([11.0, 6.0, 3.0]) && sees([11.0, 2.0, 12.0]));
        assert!(!sees([-9.0, 2.0, 3.0]) && !sees([11.0, 7.0, 3.0]) && !sees([11.0, 2.0, 13.0]));
        let mut parallel = OrthographicProjection::default_3d();
        parallel.scaling_mode = ScalingMode::Fixed { width: 60.0, height: 30.0 };
        parallel.update(200.0, 100.0);
        let found = view_of(&parallel);
        assert!((found.pixel_world - 0.3).abs() < 1e-6 && found.pixel_per_distance == 0.0, "{found:?}");
    }
}
