//! Scenes made from triangles in memory.

use std::path::Path;

use crate::far_origin::{FarOrigin, placed_at};
use crate::ply::{drop_unused, point};
use crate::validate::{Sieve, finish};
use crate::{Counts, Error, Instance, LoadOptions, Material, Mesh, Result, Scene, UpAxis};

/// Creates a scene of one mesh from vertices and the vertices of each triangle. `transmissivities` has one
/// number for each triangle, see [`Material::transmissivity`], or none if all are opaque. `up` is the axis of
/// the vertices that points up. The scene of opaque triangles equals the one that [`load`](crate::load)
/// returns for a PLY file of the same triangles with that axis. Errors name `name` in place of a file.
///
/// # Errors
/// Returns [`Error::IndexOutOfRange`] if a vertex does not exist, [`Error::NotFinite`] if a used vertex is
/// not finite as an `f32`, [`Error::Transmissivities`] if they are out of range or not one for each triangle,
/// and [`Error::NoTriangles`] or [`Error::ZeroExtent`] if nothing casts a shadow.
pub fn from_triangles(
    name: &str,
    vertices: &[[f64; 3]],
    triangles: &[[u32; 3]],
    transmissivities: &[f32],
    up: UpAxis,
) -> Result<Scene> {
    let path = Path::new(name);
    let count = vertices.len();
    if let Some(&index) = triangles.iter().flatten().find(|&&index| index as usize >= count) {
        let (index, vertices) = (index.into(), count as u64);
        return Err(Error::IndexOutOfRange { path: path.to_owned(), mesh: name.to_owned(), index, vertices });
    }
    let (materials, material_of) = materials_of(name, transmissivities, triangles.len())?;
    let corners = triangles.iter().flatten().map(|&index| vertices[index as usize]);
    let offset = FarOrigin::of(corners).offset();
    let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
    mesh.positions = vertices.iter().map(|p| std::array::from_fn(|a| (p[a] - offset[a]) as f32)).collect();
    let mut sieve = Sieve::default();
    for (&[a, b, c], material) in triangles.iter().zip(material_of) {
        if sieve.keeps([point(path, &mesh, a)?, point(path, &mesh, b)?, point(path, &mesh, c)?]) {
            mesh.triangles.push([a, b, c]);
            mesh.triangle_materials.push(material);
        }
    }
    drop_unused(&mut mesh);
    let mut scene = Scene { materials, ..Scene::default() };
    scene.notes.read = Counts { meshes: 1, nodes: 0, faces: triangles.len() as u64 };
    scene.meshes.push(mesh);
    let name = name.to_owned();
    scene.instances.push(Instance { name, mesh: 0, world_from_mesh: placed_at(offset), casts: true });
    let mut scene = finish(path, scene, &sieve, &LoadOptions::default())?;
    scene.turn_up(up);
    Ok(scene)
}

/// Returns one material for each transmissivity that occurs, in rising order, and the material of each of
/// `count` triangles.
fn materials_of(
    name: &str,
    transmissivities: &[f32],
    count: usize,
) -> Result<(Vec<Material>, impl Iterator<Item = u32>)> {
    let wrong = |what| Err(Error::Transmissivities { name: name.to_owned(), what });
    if !transmissivities.is_empty() && transmissivities.len() != count {
        let given = transmissivities.len();
        return wrong(format!("{given} numbers for {count} triangles; give one for each"));
    }
    let is_share = |share: &f32| (0.0..=1.0).contains(share);
    if let Some(at) = transmissivities.iter().position(|share| !is_share(share)) {
        return wrong(format!("the number of triangle {at} is {}; give 0 to 1", transmissivities[at]));
    }
    let mut shares = transmissivities.to_vec();
    if shares.is_empty() {
        shares.push(0.0);
    }
    shares.sort_unstable_by(f32::total_cmp);
    shares.dedup();
    let material = |&transmissivity: &f32| {
        let name = if transmissivity > 0.0 {
            format!("transmissivity {transmissivity}")
        } else {
            "default".to_owned()
        };
        Material { transmissivity, ..Material::opaque(&name, [1.0; 4]) }
    };
    let materials = shares.iter().map(material).collect();
    let number_of = move |triangle: usize| {
        let share = transmissivities.get(triangle).copied().unwrap_or_default();
        shares.partition_point(|&other| other < share) as u32
    };
    Ok((materials, (0..count).map(number_of)))
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
            let made =
                from_triangles("mesh", &VERTICES, &[[0, 1, 3], [0, 4, 1], [0, 0, 1]], &[], up).unwrap();
            assert_eq!(format!("{made:?}"), format!("{loaded:?}"));
            assert_eq!((made.notes.degenerate_triangles, made.meshes[0].positions.len()), (1, 4));
        }
    }

    #[test]
    fn from_triangles_validates_its_input() {
        let of = |triangles: &[[u32; 3]]| {
            from_triangles("mesh", &VERTICES, triangles, &[], UpAxis::Y).unwrap_err()
        };
        assert!(matches!(of(&[[0, 1, 5]]), Error::IndexOutOfRange { index: 5, vertices: 5, .. }));
        assert!(matches!(of(&[]), Error::NoTriangles { .. }));
        assert!(matches!(of(&[[0, 0, 0]]), Error::ZeroExtent { .. }));
        let infinite = [[0.0; 3], [1.0, f64::INFINITY, 0.0], [0.0, 0.0, 1.0]];
        let error = from_triangles("mesh", &infinite, &[[0, 1, 2]], &[], UpAxis::Y).unwrap_err();
        assert!(error.to_string().contains("vertex 1 of mesh \"mesh\""), "{error}");
    }

    #[test]
    fn each_transmissivity_has_a_material() {
        let made = |shares: &[f32]| {
            let triangles = [[0, 1, 3], [0, 0, 1], [0, 4, 1], [1, 4, 3]];
            from_triangles("mesh", &VERTICES, &triangles, shares, UpAxis::Z)
        };
        let scene = made(&[0.5, 0.25, -0.0, 0.5]).unwrap();
        let shares: Vec<f32> = scene.materials.iter().map(|material| material.transmissivity).collect();
        assert_eq!(shares, [0.0, 0.25, 0.5]);
        assert_eq!(scene.meshes[0].triangle_materials, [2, 0, 2]);
        assert_eq!(scene.casters().triangles, 3);
        for (shares, what) in [
            (&[0.5][..], "1 numbers for 4 triangles"),
            (&[0.0, 0.0, 1.5, 0.0], "the number of triangle 2 is 1.5; give 0 to 1"),
            (&[f32::NAN; 4], "the number of triangle 0 is NaN"),
        ] {
            let error = made(shares).unwrap_err().to_string();
            assert!(error.starts_with("mesh: wrong transmissivities: ") && error.contains(what), "{error}");
        }
    }
}
