//! The generated scenes and their views.

use adumbra::Sun;
use adumbra_render::Shot;
use adumbra_scene::{Camera, GeneratedKind, Scene, generate};

use adumbra_compare::Result;
use adumbra_compare::truth::{StreetOptions, TruthTracer, street_camera};

const SEED: u64 = 1;
/// Edge of the generated city in metres.
const CITY_SIDE: f64 = 400.0;
/// Height of a person's eyes in metres.
const EYE_HEIGHT: f64 = 1.7;
const FOV_DEGREES: f64 = 60.0;

/// A named view.
pub(super) struct NamedView {
    pub(super) name: &'static str,
    pub(super) shot: Shot,
}

pub(super) fn city() -> Scene {
    generate(GeneratedKind::City, SEED)
}

/// Returns the overview of a city, and a view along one of its streets.
pub(super) fn views(city: &Scene, sun: Sun, [width, height]: [u32; 2]) -> Result<Vec<NamedView>> {
    let street = StreetOptions { eye_height_world: EYE_HEIGHT, fov_degrees: FOV_DEGREES, width, height };
    let street = street_camera(&TruthTracer::build(city, false), sun.towards(), &street)?;
    let overview = Camera { width, height, ..Camera::overview(&city.bounds(), FOV_DEGREES) };
    let shot = |camera| Shot { camera, towards_sun: sun.towards(), number: 0 };
    Ok(vec![
        NamedView { name: "overview", shot: shot(overview) },
        NamedView { name: "street", shot: shot(street) },
    ])
}

/// Returns `side` × `side` copies of a city. The middle copy keeps the position of the city.
pub(super) fn tiled(city: &Scene, side: u32) -> Scene {
    let middle = side / 2;
    let mut all = city.clone();
    all.instances.clear();
    for (x, z) in (0..side).flat_map(|x| (0..side).map(move |z| (x, z))) {
        let [x, z] = [x, z].map(|at| (f64::from(at) - f64::from(middle)) * CITY_SIDE);
        all.instances.extend(city.instances.iter().cloned().map(|mut instance| {
            instance.world_from_mesh[0][3] += x;
            instance.world_from_mesh[2][3] += z;
            instance
        }));
    }
    all
}

/// Returns spheres around the point that a camera looks at.
pub(super) fn movers(camera: &Camera) -> Scene {
    let mut movers = generate(GeneratedKind::SphereGrid, SEED);
    for instance in &mut movers.instances {
        for axis in 0..3 {
            instance.world_from_mesh[axis][3] += camera.target[axis];
        }
    }
    movers
}

/// Returns the movers at their positions in a frame, on a circle of radius 1 m.
pub(super) fn moved(movers: &Scene, frame: u32) -> Scene {
    let (sin, cos) = (0.1 * f64::from(frame)).sin_cos();
    let mut moved = movers.clone();
    for instance in &mut moved.instances {
        instance.world_from_mesh[0][3] += cos;
        instance.world_from_mesh[2][3] += sin;
    }
    moved
}

/// Returns the number of triangles, counted once per instance.
pub(super) fn triangles(scene: &Scene) -> u64 {
    scene.instances.iter().map(|i| scene.meshes[i.mesh as usize].triangles.len() as u64).sum()
}
