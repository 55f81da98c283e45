//! The surface that a look-up receives for each pixel of a frame.

use adumbra_render::maps::twin::Surface;
use adumbra_render::{Renderer, Shot};

/// Returns the surfaces of the frame drawn last, as the shader receives them. `None` for surfaces that face
/// away from the sun and for the background.
pub(crate) fn surfaces(renderer: &Renderer, shot: &Shot) -> Vec<Option<Surface>> {
    let image = renderer.read_surface(shot).unwrap();
    let view = shot.camera.view();
    let anchor = view.eye.map(|c| f64::from(c as f32));
    let towards_sun = shot.towards_sun.map(|c| c as f32);
    let pixels = image.view_depth.iter().zip(&image.normal).enumerate();
    pixels
        .map(|(at, (&view_depth, n))| {
            let pixel = [at as u32 % shot.camera.width, at as u32 / shot.camera.width];
            let (origin, direction) = view.ray(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
            let along: f64 = (0..3).map(|a| direction[a] * view.forward[a]).sum();
            let t = f64::from(view_depth) / along;
            let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
            let normal = n.map(|c| c / length);
            let lit = (0..3).map(|a| normal[a] * towards_sun[a]).sum::<f32>() > 0.0;
            (view_depth.is_finite() && lit).then(|| Surface {
                p_relative: std::array::from_fn(|a| (origin[a] + t * direction[a] - anchor[a]) as f32),
                normal,
                towards_sun,
                view_depth,
                pixel,
            })
        })
        .collect()
}
