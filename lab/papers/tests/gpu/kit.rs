//! A device, a scene and a view of it.

use adumbra_render::{Gpu, GpuOptions, Renderer, Shot};
use adumbra_scene::{Camera, GeneratedKind, Projection, Scene, generate};

/// Opens a device. If there is none, the panic message explains how to get one.
pub(crate) fn gpu() -> Gpu {
    Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// Opens a device whose bindings hold at most this many bytes.
pub(crate) fn limited(bytes: u64) -> Gpu {
    Gpu::request(&GpuOptions { max_binding_bytes: Some(bytes), ..GpuOptions::default() }).unwrap()
}

/// Direction towards the sun, not a unit vector.
pub(crate) const SUN: [f64; 3] = [0.5, 0.8, 0.35];

/// A small generated city.
pub(crate) fn city() -> Scene {
    generate(GeneratedKind::City, 7)
}

/// A picture of the city from above.
pub(crate) fn shot() -> Shot {
    let projection = Projection::Perspective { fov_degrees: 45.0 };
    let (eye, target) = ([-150.0, 38.0, 175.0], [-75.0, 4.0, 75.0]);
    let towards_sun = adumbra::Sun::from_direction(SUN).unwrap().towards();
    Shot { camera: Camera { eye, target, projection, width: 240, height: 160 }, towards_sun, number: 0 }
}

/// A point relative to the frame's anchor, and its normal.
type Surface = ([f32; 3], [f32; 3]);

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
            let p_relative = std::array::from_fn(|a| (origin[a] + t * direction[a] - anchor[a]) as f32);
            (view_depth.is_finite() && lit).then_some((p_relative, normal))
        })
        .collect()
}
