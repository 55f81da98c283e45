//! The corners of a scene's triangles. Each position is listed once, with the number of corners there.

use std::collections::HashMap;

use adumbra_scene::{Instance, Mesh, Scene};
use rayon::prelude::*;

/// The corners of each mesh of a scene.
pub(crate) struct Corners(Vec<MeshCorners>);

struct MeshCorners {
    corners: Vec<Corner>,
    /// The least and the largest coordinates.
    extent: [[f32; 3]; 2],
}

/// A position at which triangles have corners.
#[derive(Clone, Copy)]
pub(crate) struct Corner {
    pub(crate) position: [f32; 3],
    /// Number of corners of triangles that are here.
    pub(crate) count: u32,
}

impl Corners {
    /// Counts the corners of every mesh of a scene.
    pub(crate) fn new(scene: &Scene) -> Self {
        Self(scene.meshes.par_iter().map(of_mesh).collect())
    }

    /// Returns the corners of an instance's mesh, in the order in which the mesh has them.
    pub(crate) fn of(&self, instance: &Instance) -> &[Corner] {
        &self.0[instance.mesh as usize].corners
    }

    /// Returns the corners of a box around an instance in the world.
    pub(crate) fn box_of(&self, instance: &Instance) -> [[f64; 3]; 8] {
        let extent = self.0[instance.mesh as usize].extent;
        std::array::from_fn(|i| instance.to_world(std::array::from_fn(|a| extent[i >> a & 1][a])))
    }
}

fn of_mesh(mesh: &Mesh) -> MeshCorners {
    let mut corners: Vec<Corner> = Vec::new();
    let mut places = HashMap::new();
    for &vertex in mesh.triangles.as_flattened() {
        let position = mesh.positions[vertex as usize];
        let next = corners.len();
        // Meshes with hard edges have several vertices at one position.
        let place = *places.entry(position.map(f32::to_bits)).or_insert(next);
        if place == next {
            corners.push(Corner { position, count: 0 });
        }
        corners[place].count += 1;
    }
    let mut extent = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for Corner { position, .. } in &corners {
        for a in 0..3 {
            extent[0][a] = extent[0][a].min(position[a]);
            extent[1][a] = extent[1][a].max(position[a]);
        }
    }
    MeshCorners { corners, extent }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_at_one_position_are_counted_together() {
        let mesh = Mesh {
            name: String::new(),
            positions: vec![[0.0; 3], [1.0; 3], [2.0; 3], [1.0; 3], [9.0; 3]],
            uvs: Vec::new(),
            colors: Vec::new(),
            triangles: vec![[2, 1, 0], [2, 3, 1]],
            triangle_materials: vec![0, 0],
        };
        let found: Vec<_> = of_mesh(&mesh).corners.iter().map(|c| (c.position[0], c.count)).collect();
        assert_eq!(found, [(2.0, 2), (1.0, 3), (0.0, 1)]);
    }
}
