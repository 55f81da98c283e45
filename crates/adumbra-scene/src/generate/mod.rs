//! Procedural scenes: the kinds used as tests in papers on shadows, and a city of closed boxes.
//!
//! Units are metres, Y is up. A seed gives the same bytes on every machine: the code uses only integers,
//! `f64` sums, products, quotients and roots, and `libm` for the rest. Every solid is closed and wound
//! outwards. If the scene has a ground, solids sink slightly into it.

mod ball;
mod city;
mod city_buildings;
mod city_measures;
mod city_street;
mod cornell;
mod forest;
mod ground;
mod landscape;
mod landscape_props;
mod leaf_image;
mod noise;
mod primitives;
mod pylons;
mod shapes;
mod sphere_grid;
mod spheres;
mod wires;

pub use shapes::icosphere;

use crate::{Instance, Material, Mesh, Scene};

/// The kinds of scene that [`generate`] makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GeneratedKind {
    /// A field of spheres on and above the ground, all instances of one mesh.
    Spheres,
    /// A small scene of simple shapes.
    Primitives,
    /// 400 m of low-poly terrain with a river, trees, rocks and a village.
    Landscape,
    /// 400 m of city: closed boxes in blocks between streets.
    City,
    /// A dimpled ball of radius 1 and 268,800 triangles, resting on the origin. Like the next two kinds, it
    /// has no ground.
    Ball,
    /// 25 spheres, alternately resting on y = 0 and floating: instances of one mesh of 480 triangles, 12,000
    /// triangles in total.
    SphereGrid,
    /// A pavilion of thin rods, with railings, braces and a net.
    Wires,
    /// A room 5.6 m wide and deep and 5.5 m high, open towards +Z, with coloured side walls and two blocks.
    Cornell,
    /// 248 m by 158 m of forest: 1,000 trees with 1,000 cards each, cut out by the alpha of a leaf texture.
    Forest,
    /// 2 km of a power line along a road, with lamp posts and a fence: thin things as far as one can see.
    Pylons,
}

/// Generates the scene of this kind and seed. Cost: well below a second.
pub fn generate(kind: GeneratedKind, seed: u64) -> Scene {
    match kind {
        GeneratedKind::Spheres => spheres::generate(seed),
        GeneratedKind::Primitives => primitives::generate(seed),
        GeneratedKind::Landscape => landscape::generate(seed),
        GeneratedKind::City => city::generate(seed),
        GeneratedKind::Ball => ball::generate(seed),
        GeneratedKind::SphereGrid => sphere_grid::generate(seed),
        GeneratedKind::Wires => wires::generate(seed),
        GeneratedKind::Cornell => cornell::generate(seed),
        GeneratedKind::Forest => forest::generate(seed),
        GeneratedKind::Pylons => pylons::generate(seed),
    }
}

/// A ball of radius 1 about the origin: 1,280 triangles, with the corners on the sphere.
pub(super) fn unit_ball(name: &str, material: u32) -> Mesh {
    let mut builder = shapes::MeshBuilder::new(name, material);
    builder.ball(3, |direction| direction);
    builder.finish()
}

/// Depth to which objects sink into the surface below them, metres, so that no light leaks below them.
const SINK: f64 = 0.05;

/// Assembles a scene.
#[derive(Default)]
struct Stage {
    scene: Scene,
}

/// The placement of an instance.
#[derive(Clone, Copy)]
struct Placement {
    position: [f64; 3],
    /// Rotation about Y, radians.
    yaw: f64,
    scale: [f64; 3],
}

impl Placement {
    fn at(position: [f64; 3]) -> Self {
        Self { position, yaw: 0.0, scale: [1.0; 3] }
    }

    fn turned(self, yaw: f64) -> Self {
        Self { yaw, ..self }
    }

    fn scaled(self, scale: f64) -> Self {
        Self { scale: [scale; 3], ..self }
    }
}

impl Stage {
    /// Adds an opaque material; `srgb` as in CSS, 0xRRGGBB.
    fn material(&mut self, name: &str, srgb: u32) -> u32 {
        let channel = |shift: u32| linear(f64::from(srgb >> shift & 255) / 255.0) as f32;
        self.scene.materials.push(Material::opaque(name, [channel(16), channel(8), channel(0), 1.0]));
        self.scene.materials.len() as u32 - 1
    }

    fn mesh(&mut self, mesh: Mesh) -> u32 {
        self.scene.meshes.push(mesh);
        self.scene.meshes.len() as u32 - 1
    }

    /// Places a mesh. The transform is rounded to `f32`, so that a file stores it exactly.
    fn place(&mut self, mesh: u32, name: String, place: Placement) {
        let (s, c) = (libm::sin(place.yaw), libm::cos(place.yaw));
        let [x, y, z] = place.position;
        let [sx, sy, sz] = place.scale;
        let rows = [[c * sx, 0.0, s * sz, x], [0.0, sy, 0.0, y], [-s * sx, 0.0, c * sz, z]];
        // The cosine of a quarter turn is not exactly 0.
        let world_from_mesh =
            rows.map(|row| row.map(|m| if m.abs() < 1e-12 { 0.0 } else { f64::from(m as f32) }));
        self.scene.instances.push(Instance { name, mesh, world_from_mesh, casts: true });
    }

    /// Adds a mesh with one instance at the identity transform.
    fn mesh_in_place(&mut self, mesh: Mesh) {
        let name = mesh.name.clone();
        let mesh = self.mesh(mesh);
        self.place(mesh, name, Placement::at([0.0; 3]));
    }

    fn finish(self) -> Scene {
        self.scene
    }
}

/// Converts sRGB to linear.
fn linear(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
}
