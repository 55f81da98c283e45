//! Code shared by the GPU tests.

pub(crate) mod ambient;
pub(crate) mod boxes;
pub(crate) mod buffers;
pub(crate) mod hybrid;
pub(crate) mod lists;
pub(crate) mod penumbra;
pub(crate) mod surfaces;

use adumbra_render::{Gpu, GpuOptions};
use adumbra_scene::{Camera, GeneratedKind, Projection, Scene, generate};

/// Opens a device. If there is none, the panic message explains how to get one.
pub(crate) fn gpu() -> Gpu {
    Gpu::request(&GpuOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// A small generated city.
pub(crate) fn city() -> Scene {
    generate(GeneratedKind::City, 7)
}

/// A camera over the city.
pub(crate) fn camera(width: u32, height: u32) -> Camera {
    let projection = Projection::Perspective { fov_degrees: 45.0 };
    Camera { eye: [-150.0, 38.0, 175.0], target: [-75.0, 4.0, 75.0], projection, width, height }
}

/// A unit vector towards the sun.
pub(crate) fn sun() -> [f64; 3] {
    adumbra::Sun::from_direction([0.5, 0.8, 0.35]).unwrap().towards()
}

/// The visibility of the technique `none`: everything is lit.
pub(crate) struct AllLit;

impl adumbra::PointVisibility for AllLit {
    fn visibility(&self, _p_world: [f64; 3], _normal: Option<[f64; 3]>) -> f32 {
        1.0
    }
}
