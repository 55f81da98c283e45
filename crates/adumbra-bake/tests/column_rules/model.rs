//! Small scenes built by hand, and helpers to bake and query them.

use adumbra::{Filter, ShadowFile};
use adumbra_bake::{Bake, BakeOptions};
use adumbra_scene::{Instance, Material, Mesh, Scene};
use adumbra_testing::toothed_bar;

pub(crate) type Point = [f64; 3];

pub(crate) const UP: Point = [0.0, 1.0, 0.0];

/// One mesh.
#[derive(Clone, Default)]
pub(crate) struct Model {
    mesh: Mesh,
}

impl Model {
    pub(crate) fn triangle(&mut self, corners: [Point; 3]) {
        let first = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(corners.map(|p| p.map(|c| c as f32)));
        self.mesh.triangles.push([first, first + 1, first + 2]);
        self.mesh.triangle_materials.push(0);
    }

    pub(crate) fn quad(&mut self, [a, b, c, d]: [Point; 4]) {
        self.triangle([a, b, c]);
        self.triangle([a, c, d]);
    }

    /// Adds a level square that faces up.
    pub(crate) fn level_square(&mut self, half: f64, y: f64) {
        self.quad([[-half, y, -half], [-half, y, half], [half, y, half], [half, y, -half]]);
    }

    /// Adds a closed hexahedron; bit a of a corner's number is its side along axis a.
    pub(crate) fn hexahedron(&mut self, corners: [Point; 8]) {
        for face in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            self.quad(face.map(|c: usize| corners[c]));
        }
    }

    pub(crate) fn cuboid(&mut self, low: Point, high: Point) {
        self.hexahedron(box_corners(low, high));
    }

    /// Adds a closed bar whose top is a row of teeth along x, each `pitch` wide. `y` has the heights of the
    /// bottom, the valleys and the tips.
    pub(crate) fn toothed_bar(&mut self, x: [f64; 2], y: [f64; 3], z: [f64; 2], pitch: f64) {
        let teeth = ((x[1] - x[0]) / pitch) as usize;
        toothed_bar(x[0], teeth, pitch, y, z).into_iter().for_each(|face| self.quad(face));
    }
}

/// Returns the corners of a box, for [`Model::hexahedron`].
pub(crate) fn box_corners(low: Point, high: Point) -> [Point; 8] {
    std::array::from_fn(|c| [0, 1, 2].map(|a| if c >> a & 1 == 0 { low[a] } else { high[a] }))
}

/// Builds a scene with each model as its own instance, without a transform.
pub(crate) fn scene(models: &[Model]) -> Scene {
    let instance = |mesh: usize| Instance {
        name: String::new(),
        mesh: mesh as u32,
        world_from_mesh: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
        casts: true,
    };
    Scene {
        meshes: models.iter().map(|model| model.mesh.clone()).collect(),
        instances: (0..models.len()).map(instance).collect(),
        materials: vec![Material::opaque("white", [1.0; 4])],
        ..Scene::default()
    }
}

pub(crate) fn bake_quietly(scene: &Scene, options: &BakeOptions) -> ShadowFile {
    Bake::with_options(scene, options).in_memory().expect("a small bake fits")
}

/// Returns how many of these points on level ground are lit.
pub(crate) fn lit_on_ground(baked: &ShadowFile, points: &[Point]) -> usize {
    let sampler = baked.sampler(Filter::Nearest);
    points.iter().filter(|&&p| sampler.visibility(p, Some(UP)) > 0.5).count()
}
