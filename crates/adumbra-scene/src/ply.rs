//! Loads PLY as Greg Turk defines it (*The PLY Polygon File Format*, 1994) and as scanners and modelling
//! programs write it: text and both binary byte orders, polygons and triangle strips.
//!
//! PLY has no names or materials. The node and the mesh get the file's name, and the material is called
//! `default`. Colours, normals and texture coordinates are skipped, because none of them decides where a
//! surface is opaque.

mod header;
#[cfg(test)]
mod mutations;
mod polygons;
mod records;
mod values;

use std::path::Path;

use polygons::Polygons;
use records::{Records, STATED_BYTES};

use crate::far_origin::{FarOrigin, placed_at};
use crate::polygon::Cutter;
use crate::sources::Sources;
use crate::validate::{Sieve, check_vertex, finish};
use crate::{EmptyReason, Error, Instance, LoadOptions, Material, Mesh, Result, Scene};

/// Bytes per triangle: its corners and its material.
const TRIANGLE_BYTES: u64 = 16;
/// Bytes per corner of the face that is being cut.
const POINT_BYTES: u64 = 12;

/// Loads a `.ply` file.
pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let sources = Sources::new(path, "PLY", options);
    let bytes = sources.read_scene()?;
    scene_of(&sources, bytes, options)
}

/// The scene of a whole file, whose length is counted in the budget.
fn scene_of(sources: &Sources<'_>, bytes: Vec<u8>, options: &LoadOptions) -> Result<Scene> {
    let path = sources.scene;
    let name = path.file_stem().map_or_else(|| "mesh".to_owned(), |s| s.to_string_lossy().into_owned());
    let mut scene = Scene { materials: vec![Material::opaque("default", [1.0; 4])], ..Scene::default() };
    let Records { positions: stated, faces, strips } =
        records::read(sources, &bytes, &name, &mut scene.notes)?;
    sources.budget.release(bytes.len() as u64);
    drop(bytes);
    scene.notes.read.meshes = 1;
    scene.notes.read.faces = faces.count() + strips.triangles() as u64;
    let mut sieve = Sieve::default();
    let marks = [&name, &name, "default"].map(|name| options.filter.marks(name, &mut sieve.met));
    if !options.filter.keeps_marked(marks) {
        sieve.filtered = true;
        return finish(path, scene, &sieve, options);
    }
    let triangles = faces.triangles() + strips.triangles();
    if triangles == 0 && !stated.is_empty() && scene.notes.omissions.is_empty() {
        return Err(Error::NoTriangles { path: path.to_owned(), reason: EmptyReason::PointCloud });
    }
    // Only corners count: a file may hold any value in vertices that no face uses.
    let corners = faces.corners.iter().chain(&strips.corners);
    let offset = FarOrigin::of(corners.filter_map(|&i| stated.get(i as usize).copied())).offset();
    let mut mesh = Mesh { name: name.clone(), ..Mesh::default() };
    mesh.positions = stated.iter().map(|p| std::array::from_fn(|a| (p[a] - offset[a]) as f32)).collect();
    sources.budget.release(STATED_BYTES * stated.len() as u64);
    drop(stated);
    sources.budget.charge(TRIANGLE_BYTES * triangles as u64, || format!("{triangles} triangles"))?;
    mesh.triangles.reserve_exact(triangles);
    scene.notes.untriangulated_polygons = add_faces(sources, &mut mesh, &faces, &mut sieve)?;
    add_strips(path, &mut mesh, &strips, &mut sieve)?;
    drop((faces, strips));
    drop_unused(&mut mesh);
    mesh.triangle_materials = vec![0; mesh.triangles.len()];
    scene.meshes.push(mesh);
    scene.instances.push(Instance { name, mesh: 0, world_from_mesh: placed_at(offset), casts: true });
    finish(path, scene, &sieve, options)
}

/// The position of a corner; an error if it is not finite.
pub(super) fn point(path: &Path, mesh: &Mesh, corner: u32) -> Result<[f32; 3]> {
    let p = mesh.positions.get(corner as usize).copied().unwrap_or([f32::NAN; 3]);
    check_vertex(path, &mesh.name, u64::from(corner), p)?;
    Ok(p)
}

/// Adds the triangles of polygons. Returns how many polygons could not be triangulated.
fn add_faces(sources: &Sources<'_>, mesh: &mut Mesh, faces: &Polygons, sieve: &mut Sieve) -> Result<u64> {
    let largest = faces.largest();
    sources.budget.charge(POINT_BYTES * largest as u64, || format!("a face of {largest} corners"))?;
    let (mut cutter, mut points) = (Cutter::default(), Vec::with_capacity(largest));
    for corners in faces.iter() {
        points.clear();
        for &corner in corners {
            points.push(point(sources.scene, mesh, corner)?);
        }
        let mut add = |triangle: [usize; 3]| {
            if sieve.keeps(triangle.map(|i| points[i])) {
                mesh.triangles.push(triangle.map(|i| corners[i]));
            }
        };
        match cutter.cut(&points) {
            Some(triangles) => triangles.iter().for_each(|t| add(t.map(|i| i as usize))),
            None => (2..corners.len()).for_each(|i| add([0, i - 1, i])),
        }
    }
    sources.budget.release(POINT_BYTES * largest as u64);
    Ok(cutter.failed)
}

/// Adds the triangles of strips. Every second triangle is reversed, so that all have the winding of the
/// first.
fn add_strips(path: &Path, mesh: &mut Mesh, strips: &Polygons, sieve: &mut Sieve) -> Result<()> {
    for corners in strips.iter() {
        for (index, &[a, b, c]) in corners.array_windows().enumerate() {
            let triangle = if index % 2 == 0 { [a, b, c] } else { [b, a, c] };
            let mut points = [[0.0; 3]; 3];
            for (p, corner) in points.iter_mut().zip(triangle) {
                *p = point(path, mesh, corner)?;
            }
            if sieve.keeps(points) {
                mesh.triangles.push(triangle);
            }
        }
    }
    Ok(())
}

/// Removes vertices that no triangle uses, which have not been validated.
pub(super) fn drop_unused(mesh: &mut Mesh) {
    let mut new_index = vec![u32::MAX; mesh.positions.len()];
    for &corner in mesh.triangles.iter().flatten() {
        if let Some(slot) = new_index.get_mut(corner as usize) {
            *slot = 0;
        }
    }
    let mut next = 0;
    let mut kept = Vec::with_capacity(new_index.iter().filter(|&&i| i == 0).count());
    for (slot, &p) in new_index.iter_mut().zip(&mesh.positions) {
        if *slot == 0 {
            *slot = next;
            next += 1;
            kept.push(p);
        }
    }
    mesh.positions = kept;
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = new_index.get(*corner as usize).copied().unwrap_or_default();
    }
}
