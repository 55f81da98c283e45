//! Validation of cameras.

use adumbra_scene::{Camera, Projection};

use crate::error::{RenderError, Result};

/// Checks that a frame can be drawn from a camera.
///
/// # Errors
/// Returns [`RenderError::Camera`] if the camera has no pixels, is not finite, has no direction, or sees
/// nothing.
pub(crate) fn check_camera(camera: &Camera) -> Result<()> {
    let wrong = |reason| Err(RenderError::Camera { reason });
    if camera.width == 0 || camera.height == 0 {
        return wrong("its picture has no pixels");
    }
    if !camera.eye.iter().chain(&camera.target).all(|c| (*c as f32).is_finite()) {
        return wrong("its eye or its target is not finite");
    }
    match camera.projection {
        Projection::Perspective { fov_degrees } if !(fov_degrees > 0.0 && fov_degrees < 180.0) => {
            return wrong("its field of view is not between 0 and 180 degrees");
        }
        Projection::Orthographic { height_world } if !(height_world > 0.0 && height_world.is_finite()) => {
            return wrong("the height of what it sees is not above 0 and finite");
        }
        _ => {}
    }
    let view = camera.view();
    let axes = [view.forward, view.right, view.up];
    if !axes.iter().flatten().chain(&view.half).all(|c| c.is_finite()) {
        return wrong("its eye is at its target");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rejects_cameras_that_see_nothing() {
        let fine = Camera {
            eye: [0.0; 3],
            target: [0.0, 0.0, -1.0],
            projection: Projection::Perspective { fov_degrees: 45.0 },
            width: 1,
            height: 1,
        };
        assert!(check_camera(&fine).is_ok());
        let flat = |height_world| Projection::Orthographic { height_world };
        let wide = |fov_degrees| Projection::Perspective { fov_degrees };
        for wrong in [
            Camera { width: 0, ..fine },
            Camera { height: 0, ..fine },
            Camera { eye: [f64::NAN, 0.0, 0.0], ..fine },
            Camera { target: [0.0, f64::INFINITY, 0.0], ..fine },
            Camera { target: fine.eye, ..fine },
            Camera { projection: wide(0.0), ..fine },
            Camera { projection: wide(180.0), ..fine },
            Camera { projection: wide(f64::NAN), ..fine },
            Camera { projection: flat(-1.0), ..fine },
            Camera { projection: flat(f64::INFINITY), ..fine },
        ] {
            assert!(matches!(check_camera(&wrong), Err(RenderError::Camera { .. })), "{wrong:?}");
        }
    }
}
