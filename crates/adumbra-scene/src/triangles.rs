//! Scenes made from triangles in memory.

use std::path::Path;

use crate::far_origin::{FarOrigin, placed_at};
use crate::ply::{drop_unused, point};
use crate::validate::{Sieve, finish};
use crate::{Counts, Error, Instance, LoadOptions, Material, Mesh, Result, Scene, UpAxis};

/// Creates a scene of one opaque mesh from vertices and the vertices of each triangle. `up` is the axis of
/// the vertices that points up. The scene equals the one that [`load`](crate::load) returns for a PLY file of
/// the same triangles with that axis. Errors name `name` in place of a file.
///
/// # Errors
/// Returns [`Error::IndexOutOfRange`] if a vertex does not exist, [`Error::NotFinite`] if a used vertex is
/// not finite as an `f32`, and [`Error::NoTriangles`] or [`Error::ZeroExtent`] if nothing casts a shadow.
pub fn from_triangles(
    name: &str,
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    up: UpAxis,
) -> Result<Scene> {
    let path = Path::new(name);
    let count = vertices.len();
    if let Some(&index) = triangles.iter().flatten().find(|&&index| index as usize >= count) {
        let (index, vertices) = (index.into(), count as u64);
        return Err(Error::IndexOutOfRange { path: path.to_owned(), mesh: name.to_owned(), index, vertices });
    }
    let corners = triangles.iter().flatten().map(|&index| vertices[index as usize]);
    let offset = FarOrigin::of(corners).offset();
    let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
    mesh.positions = vertices.iter().map(|p| std::array::from_fn(|a| (p[a] - offset[a]) as f32)).collect();
    let mut sieve = Sieve::default();
    for &[a, b, c] in triangles {
        if sieve.keeps([point(path, &mesh, a)?, point(path, &mesh, b)?, point(path, &mesh, c)?]) {
            mesh.triangles.push([a, b, c]);
        }
    }
    drop_unused(&mut mesh);
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    let mut scene = Scene { materials: vec![Material::opaque("default", [1.0; 4])], ..Scene::default() };
    scene.notes.read = Counts { meshes: 1, nodes: 0, faces: triangles.len() as u64 };
    scene.meshes.push(mesh);
    let name = name.to_owned();
    scene.instances.push(Instance { name, mesh: 0, world_from_mesh: placed_at(offset), casts: true });
    let mut scene = finish(path, scene, &sieve, &LoadOptions::default())?;
    scene.turn_up(up);
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    const VERTICES: [[f64; 3]; 5] =
        [[5e6, 0.0, 0.0], [5e6 + 1.5, 0.0, 0.0], [9.0; 3], [5e6, 0.0, 2.0], [5e6, 3.25, 0.0]];

    #[test]
    fn from_triangles_equals_loading_a_ply_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        let header = "ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\nproperty double y\n\
            property double z\nelement face 3\nproperty list uchar int vertex_indices\nend_header\n";
        let rows: String = VERTICES.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
        std::fs::write(&path, format!("{header}{rows}3 0 1 3\n3 0 4 1\n3 0 0 1\n")).unwrap();
        for up in [UpAxis::Y, UpAxis::Z] {
            let loaded = crate::load(&path, &LoadOptions { up: Some(up), ..LoadOptions::default() }).unwrap();
            let made = from_triangles("mesh", &VERTICES, &[[0, 1, 3], [0, 4, 1], [0, 0, 1]], up).unwrap();
            assert_eq!(format!("{made:?}"), format!("{loaded:?}"));
            assert_eq!((made.notes.degenerate_triangles, made.meshes[0].positions.len()), (1, 4));
        }
    }

    #[test]
    fn from_triangles_validates_its_input() {
        let of =
            |triangles: &[[u32; 3]]| from_triangles("mesh", &VERTICES, triangles, UpAxis::Y).unwrap_err();
        assert!(matches!(of(&[[0, 1, 5]]), Error::IndexOutOfRange { index: 5, vertices: 5, .. }));
        assert!(matches!(of(&[]), Error::NoTriangles { .. }));
        assert!(matches!(of(&[[0, 0, 0]]), Error::ZeroExtent { .. }));
        let infinite = [[0.0; 3], [1.0, f64::INFINITY, 0.0], [0.0, 0.0, 1.0]];
        let error = from_triangles("mesh", &infinite, &[[0, 1, 2]], UpAxis::Y).unwrap_err();
        assert!(error.to_string().contains("vertex 1 of mesh \"mesh\""), "{error}");
    }
}
