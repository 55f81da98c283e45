//! A camera's frame: its uniform, its targets and the G-buffer pass.
//!
//! Targets: depth (Depth32Float, reversed: see [`Frame`]), normals (Rgba16Float, world space, facing the
//! viewer), base colour (Rgba8UnormSrgb), shadow factor (R32Float, 1 = lit), picture (Rgba8Unorm,
//! sRGB-encoded).
//!
//! - *Positions* are relative to the frame's anchor, the eye. Instances, lights and grids subtract it in
//!   `f64`, so `f32` is most precise near the camera, wherever in the world that is.
//! - *The near plane* is 1 mm away, or nearer for models of a few millimetres. With reversed floating-point
//!   depth this costs no precision.
//! - *Normals* are those of the triangles, as in the ray tracer. Slopes and biases are therefore exact, not
//!   estimated in screen space.
//! - *Masked surfaces* are alpha-tested at full resolution with the alpha of material, texture and vertex, as
//!   in the bake and the ray tracer.
//! - *Colours* are sampled with mip levels, which are generated once for CPU and GPU. The shader computes the
//!   level itself, because devices differ in how they select it.

mod check;
mod gbuffer;
mod sight;
mod targets;

pub(crate) use check::check_camera;
pub use gbuffer::GBuffer;
pub(crate) use sight::depths_in_view;
pub(crate) use targets::FACTOR_FORMAT;
pub use targets::{DEPTH_FORMAT, Target, Targets};

use adumbra::Bounds;
use adumbra_scene::{Camera, View};
use adumbra_shaders::layout::{DepthToZ, Frame};

use crate::scene::Volume;

/// Distance of a perspective camera's near plane, world units. With reversed floating-point depth, a small
/// distance costs no precision.
const NEAR_WORLD: f64 = 1e-3;
/// Upper bound of the near plane as a fraction of the distance from eye to target, for models of a few
/// millimetres.
const NEAR_SHARE: f64 = 1e-3;

/// Returns the frame uniform of `camera`, relative to its eye, for a scene within `bounds`.
pub fn frame(camera: &Camera, bounds: &Bounds, towards_sun: [f64; 3], number: u32) -> Frame {
    let view = camera.view();
    let wide = |v: [f64; 3], w: f64| [v[0] as f32, v[1] as f32, v[2] as f32, w as f32];
    let scaled = |v: [f64; 3], k: f64| v.map(|c| c * k);
    let (right, up) = (scaled(view.right, view.half[0]), scaled(view.up, view.half[1]));
    let look = (0..3).map(|a| (camera.target[a] - camera.eye[a]).powi(2)).sum::<f64>().sqrt();
    let near = NEAR_WORLD.min(NEAR_SHARE * look).max(f64::from(f32::MIN_POSITIVE));
    let far = far_plane(&view, bounds);
    let x = scaled(view.right, 1.0 / view.half[0]);
    let y = scaled(view.up, 1.0 / view.half[1]);
    let f = view.forward;
    // Rows of the matrix from relative positions to clip space; depth is reversed.
    let rows = if view.orthographic {
        [wide(x, 0.0), wide(y, 0.0), wide(scaled(f, -1.0 / far), 1.0), [0.0, 0.0, 0.0, 1.0]]
    } else {
        [wide(x, 0.0), wide(y, 0.0), [0.0, 0.0, 0.0, near as f32], wide(f, 0.0)]
    };
    let single = |v: [f64; 3]| v.map(|c| c as f32);
    let aside = |v: [f64; 3], when: bool| if when { single(v) } else { [0.0; 3] };
    Frame {
        clip_from_relative: std::array::from_fn(|c| std::array::from_fn(|r| rows[r][c])),
        origin: [0.0; 3],
        origin_x: aside(right, view.orthographic),
        origin_y: aside(up, view.orthographic),
        ray: single(f),
        ray_x: aside(right, !view.orthographic),
        ray_y: aside(up, !view.orthographic),
        depth_to_z: if view.orthographic {
            let far = far as f32;
            DepthToZ { numerator: far, numerator_slope: -far, denominator: 1.0, denominator_slope: 0.0 }
        } else {
            let near = near as f32;
            DepthToZ { numerator: near, numerator_slope: 0.0, denominator: 0.0, denominator_slope: 1.0 }
        },
        anchor_world: single(view.eye),
        anchor_rest_world: single(view.eye.map(|c| c - f64::from(c as f32))),
        towards_sun: single(towards_sun),
        forward: single(f),
        size: [camera.width, camera.height],
        number,
    }
}

/// Distance of an orthographic camera's far plane: just behind everything in view.
fn far_plane(view: &View, bounds: &Bounds) -> f64 {
    depths_in_view(view, bounds).map_or(0.0, |[_, farthest]| farthest) * 1.001 + 1e-6
}

/// Returns the view volume of a camera, without a far plane, in world space.
pub(crate) fn visible_volume(view: &View) -> Volume {
    let [x, y, z] = view.eye;
    let in_world = |[a, b, c, w]: [f64; 4]| [a, b, c, w - (a * x + b * y + c * z)];
    Volume { planes: sight::planes(view).map(in_world).into() }
}

#[cfg(test)]
mod tests {
    use adumbra_scene::Projection;

    use super::*;

    const BOUNDS: Bounds = Bounds { min: [-20.0; 3], max: [30.0; 3] };

    fn camera(projection: Projection) -> Camera {
        Camera { eye: [3.0, 4.0, 5.0], target: [-2.0, 1.0, -6.0], projection, width: 64, height: 40 }
    }

    #[test]
    fn frame_projection_and_reconstruction_are_inverse() {
        for projection in
            [Projection::Perspective { fov_degrees: 55.0 }, Projection::Orthographic { height_world: 12.0 }]
        {
            let camera = camera(projection);
            let (view, frame) = (camera.view(), frame(&camera, &BOUNDS, [0.0, 1.0, 0.0], 0));
            for (px, py, t) in [(10.0, 7.0, 3.0), (50.5, 33.0, 17.0)] {
                let (origin, direction) = view.ray(px, py);
                let p: [f64; 3] = std::array::from_fn(|a| origin[a] + t * direction[a]);
                let relative = [0, 1, 2].map(|a| (p[a] - view.eye[a]) as f32);
                let clip: [f32; 4] = std::array::from_fn(|r| {
                    let column = |c: usize| frame.clip_from_relative[c][r];
                    (0..3).map(|c| column(c) * relative[c]).sum::<f32>() + column(3)
                });
                let ndc = [clip[0] / clip[3], clip[1] / clip[3]];
                assert!((f64::from(ndc[0]) - (2.0 * px / 64.0 - 1.0)).abs() < 1e-5);
                assert!((f64::from(ndc[1]) - (1.0 - 2.0 * py / 40.0)).abs() < 1e-5);
                let depth = clip[2] / clip[3];
                assert!(depth > 0.0 && depth <= 1.0);
                let z = frame.depth_to_z.view_depth(depth);
                assert!((f64::from(z) - view.depth(p)).abs() < 1e-4, "{z} {}", view.depth(p));
                for (a, expected) in relative.into_iter().enumerate() {
                    let origin = frame.origin_x[a] * ndc[0] + frame.origin_y[a] * ndc[1];
                    let ray = frame.ray[a] + frame.ray_x[a] * ndc[0] + frame.ray_y[a] * ndc[1];
                    assert!((origin + z * ray - expected).abs() < 1e-3);
                }
            }
        }
    }

    #[test]
    fn visible_volume_separates_visible_from_hidden_points() {
        for projection in
            [Projection::Perspective { fov_degrees: 55.0 }, Projection::Orthographic { height_world: 12.0 }]
        {
            let view = camera(projection).view();
            let volume = visible_volume(&view);
            let at = |x: f64, y: f64| {
                let (origin, direction) = view.ray(x, y);
                std::array::from_fn::<f64, 3, _>(|a| origin[a] + 5.0 * direction[a])
            };
            assert!(volume.may_touch(at(1.0, 1.0), [0.0; 3]));
            assert!(volume.may_touch(at(63.0, 39.0), [0.0; 3]));
            assert!(!volume.may_touch(at(-3.0, 20.0), [0.0; 3]));
            assert!(!volume.may_touch(at(30.0, 43.0), [0.0; 3]));
            assert!(!volume.may_touch(std::array::from_fn(|a| view.eye[a] - view.forward[a]), [0.0; 3]));
        }
    }
}
