//! Movement of cameras and of the sun. Cameras do not roll. Neither cameras nor the sun pass over a pole.

use adumbra::Sun;
use adumbra_scene::{Camera, Projection};

/// Smallest angle in degrees between a camera's view and straight up or down, and between the sun and the
/// horizon or the zenith.
const MARGIN_DEGREES: f64 = 0.5;

/// Returns the azimuth, clockwise from -Z, and the elevation of a direction, in degrees; the inverse of
/// [`Sun::from_angles`].
pub(crate) fn angles(towards: [f64; 3]) -> [f64; 2] {
    let flat = towards[0].hypot(towards[2]);
    let azimuth = towards[0].atan2(-towards[2]).to_degrees();
    [azimuth.rem_euclid(360.0), towards[1].atan2(flat).to_degrees()]
}

/// Returns the unit vector with these angles.
fn direction([azimuth, elevation]: [f64; 2]) -> [f64; 3] {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    let flat = elevation.cos();
    [flat * azimuth.sin(), elevation.sin(), -flat * azimuth.cos()]
}

fn turned(from: [f64; 3], [right, up]: [f64; 2]) -> [f64; 3] {
    let [azimuth, elevation] = angles(from);
    let most = 90.0 - MARGIN_DEGREES;
    direction([azimuth + right, (elevation + up).clamp(-most, most)])
}

fn offset(camera: &Camera) -> [f64; 3] {
    std::array::from_fn(|a| camera.target[a] - camera.eye[a])
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Moves the eye around the target, by degrees to the right and up.
pub(crate) fn orbit(camera: &mut Camera, [right, up]: [f64; 2]) {
    let distance = length(offset(camera));
    let ahead = turned(offset(camera), [-right, -up]);
    camera.eye = std::array::from_fn(|a| camera.target[a] - distance * ahead[a]);
}

/// Moves the target around the eye, by degrees to the right and up.
pub(crate) fn look(camera: &mut Camera, degrees: [f64; 2]) {
    let distance = length(offset(camera));
    let ahead = turned(offset(camera), degrees);
    camera.target = std::array::from_fn(|a| camera.eye[a] + distance * ahead[a]);
}

/// Moves eye and target together to the right and up, in fractions of the visible height at the target.
pub(crate) fn pan(camera: &mut Camera, [right, up]: [f64; 2]) {
    let view = camera.view();
    let height = match camera.projection {
        Projection::Perspective { .. } => 2.0 * view.half[1] * length(offset(camera)),
        Projection::Orthographic { height_world } => height_world,
    };
    shift(camera, std::array::from_fn(|a| height * (right * view.right[a] + up * view.up[a])));
}

/// Moves eye and target together to the right, up and ahead, in distances from eye to target.
pub(crate) fn fly(camera: &mut Camera, [right, up, ahead]: [f64; 3]) {
    let (view, distance) = (camera.view(), length(offset(camera)));
    let world_up = [0.0, 1.0, 0.0];
    shift(
        camera,
        std::array::from_fn(|a| {
            distance * (right * view.right[a] + up * world_up[a] + ahead * view.forward[a])
        }),
    );
}

fn shift(camera: &mut Camera, by: [f64; 3]) {
    for (a, by) in by.into_iter().enumerate() {
        camera.eye[a] += by;
        camera.target[a] += by;
    }
}

/// Multiplies the eye's distance from the target, and the visible height of an orthographic camera, by a
/// factor.
pub(crate) fn zoom(camera: &mut Camera, factor: f64) {
    if let Projection::Orthographic { height_world } = &mut camera.projection {
        *height_world *= factor;
    }
    let (o, target) = (offset(camera), camera.target);
    camera.eye = std::array::from_fn(|a| target[a] - factor * o[a]);
}

/// Turns the sun by degrees. It stays above the horizon and off the zenith.
pub(crate) fn turn_sun(sun: &Sun, [azimuth, elevation]: [f64; 2]) -> Sun {
    let [a, e] = angles(sun.towards());
    let e = (e + elevation).clamp(MARGIN_DEGREES, 90.0 - MARGIN_DEGREES);
    Sun::from_angles((a + azimuth).rem_euclid(360.0), e).unwrap_or(*sun)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        let projection = Projection::Perspective { fov_degrees: 60.0 };
        Camera { eye: [3.0, 4.0, 8.0], target: [1.0, 1.0, -2.0], projection, width: 400, height: 300 }
    }

    fn near(a: [f64; 3], b: [f64; 3]) {
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-9), "{a:?} {b:?}");
    }

    #[test]
    fn angles_are_the_inverse_of_sun_from_angles() {
        for (azimuth, elevation) in [(0.0, 30.0), (90.0, 5.0), (200.5, 60.0), (359.0, 80.0)] {
            let [a, e] = angles(Sun::from_angles(azimuth, elevation).unwrap().towards());
            assert!((a - azimuth).abs() < 1e-9 && (e - elevation).abs() < 1e-9, "{a} {e}");
        }
    }

    #[test]
    fn orbit_keeps_the_distance_and_comes_back() {
        let mut moved = camera();
        orbit(&mut moved, [40.0, 12.0]);
        assert!((length(offset(&moved)) - length(offset(&camera()))).abs() < 1e-9);
        assert!(moved.eye[1] > camera().eye[1], "up raises the eye");
        orbit(&mut moved, [-40.0, -12.0]);
        near(moved.eye, camera().eye);
        orbit(&mut moved, [0.0, -500.0]);
        assert!(moved.view().right.iter().all(|c| c.is_finite()) && moved.eye[1] < moved.target[1]);
    }

    #[test]
    fn look_keeps_the_eye_and_fly_goes_ahead() {
        let mut moved = camera();
        look(&mut moved, [90.0, 0.0]);
        near(moved.eye, camera().eye);
        let flat = |c: &Camera| [offset(c)[0], offset(c)[2]];
        let ([x, z], [u, v]) = (flat(&camera()), flat(&moved));
        assert!((x * u + z * v).abs() < 1e-9, "a quarter turn");
        let mut moved = camera();
        fly(&mut moved, [0.0, 0.0, 1.0]);
        near(moved.eye, camera().target);
    }

    #[test]
    fn pan_moves_by_a_fraction_of_the_visible_height() {
        let mut moved = camera();
        pan(&mut moved, [0.25, 0.0]);
        let [x, y] = moved.view().pixel(camera().target).unwrap();
        assert!((x - (200.0 - 0.25 * 300.0)).abs() < 1e-6 && (y - 150.0).abs() < 1e-6, "{x} {y}");
    }

    #[test]
    fn zoom_and_sun_keep_to_their_limits() {
        let mut moved = camera();
        zoom(&mut moved, 0.5);
        assert!((length(offset(&moved)) * 2.0 - length(offset(&camera()))).abs() < 1e-9);
        let sun = Sun::from_angles(10.0, 20.0).unwrap();
        assert!((turn_sun(&sun, [5.0, -90.0]).elevation_degrees() - 0.5).abs() < 1e-9);
        assert!((turn_sun(&sun, [5.0, 90.0]).elevation_degrees() - 89.5).abs() < 1e-9);
    }
}
