//! Loads Wavefront OBJ with its MTL: one mesh an object or group name, polygons cut into fans.
//!
//! `tobj` groups, triangulates and reads materials; [`tidy`] first rewrites the file to the part of the format that
//! `tobj` is sure of, and reports broken lines by number.

mod tidy;

use std::collections::HashMap;
use std::path::Path;

use super::affine::IDENTITY;
use super::validate::{Sieve, check_vertex, finish, read};
use super::{AlphaMode, Instance, LoadNotes, LoadOptions, Material, Mesh, Pixels, Scene, Texture};
use crate::error::{Error, Result};

/// Materials as `tobj` hands them on: a list, and where each name is in it.
type Library = (Vec<tobj::Material>, HashMap<String, usize>);

/// Loads a `.obj` file.
pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let bytes = read(path, "OBJ")?;
    let tidied = tidy::object(path, &bytes, options.color_textures)?;
    drop(bytes);
    let mut scene = Scene::default();
    scene.notes.skipped_primitives = tidied.skipped;
    let library = read_libraries(path, &tidied, &mut scene.notes);
    let loading = tobj::LoadOptions { single_index: true, triangulate: true, ..tobj::LoadOptions::default() };
    let (models, _) = tobj::load_obj_buf(&mut &tidied.text[..], &loading, |_| Ok(library.clone()))
        .map_err(|e| Error::SceneParse { path: path.to_owned(), format: "OBJ", what: e.to_string() })?;
    drop(tidied);

    let mut materials: Vec<Material> = library.0.iter().map(|m| material(m, options)).collect();
    materials.push(Material::opaque("default", [0.8, 0.8, 0.8, 1.0]));
    let mut sieve = Sieve::default();
    let mut by_name: HashMap<String, usize> = HashMap::new();
    let mut used = vec![false; materials.len()];
    for model in models {
        let material = model.mesh.material_id.unwrap_or(library.0.len());
        let Some(named) = materials.get(material) else { continue };
        if !options.filter.keeps(&model.name, &model.name, &named.name) {
            sieve.filtered = true;
            continue;
        }
        if let Some(used) = used.get_mut(material) {
            *used = true;
        }
        let next = scene.meshes.len();
        let index = *by_name.entry(model.name.clone()).or_insert(next);
        if index == next {
            scene.meshes.push(Mesh { name: model.name, ..Mesh::default() });
        }
        if let Some(mesh) = scene.meshes.get_mut(index) {
            append(path, mesh, &model.mesh, material as u32, options.color_textures, &mut sieve)?;
        }
    }
    if options.color_textures {
        load_textures(path, &library.0, &used, &mut materials, &mut scene);
    }
    scene.instances = (0_u32..)
        .zip(&scene.meshes)
        .map(|(mesh, m)| Instance { name: m.name.clone(), mesh, world_from_mesh: IDENTITY, casts: true })
        .collect();
    scene.materials = materials;
    finish(path, scene, &sieve, options)
}

/// Adds the triangles of one model.
fn append(
    path: &Path,
    mesh: &mut Mesh,
    model: &tobj::Mesh,
    material: u32,
    with_uvs: bool,
    sieve: &mut Sieve,
) -> Result<()> {
    let base = mesh.positions.len() as u32;
    let broken = || Error::SceneParse {
        path: path.to_owned(),
        format: "OBJ",
        what: format!("object {:?} is inconsistent", mesh.name),
    };
    let (positions, _) = model.positions.as_chunks::<3>();
    let (faces, _) = model.indices.as_chunks::<3>();
    let mut triangles = Vec::with_capacity(faces.len());
    for face in faces {
        let mut points = [[0.0; 3]; 3];
        for (point, &corner) in points.iter_mut().zip(face) {
            *point = *positions.get(corner as usize).ok_or_else(broken)?;
            check_vertex(path, &mesh.name, u64::from(corner), *point)?;
        }
        if sieve.keeps(points) {
            triangles.push(face.map(|corner| corner + base));
        }
    }
    mesh.triangles.append(&mut triangles);
    mesh.triangle_materials.resize(mesh.triangles.len(), material);
    mesh.positions.extend_from_slice(positions);
    if with_uvs {
        // OBJ has its origin at the bottom left.
        let (uvs, _) = model.texcoords.as_chunks::<2>();
        mesh.uvs.extend(uvs.iter().map(|&[u, v]| [u, 1.0 - v].map(|c| if c.is_finite() { c } else { 0.0 })));
        mesh.uvs.resize(mesh.positions.len(), [0.0; 2]);
    }
    Ok(())
}

/// Reads every MTL file, and makes up an opaque material for each name that is in none.
fn read_libraries(path: &Path, tidied: &tidy::Object, notes: &mut LoadNotes) -> Library {
    let (mut list, mut by_name): Library = Default::default();
    let mut missing = Vec::new();
    for name in &tidied.libraries {
        let Ok(bytes) = std::fs::read(beside(path, name)) else {
            missing.push(name);
            continue;
        };
        match tobj::load_mtl_buf(&mut &tidy::materials(&bytes)[..]) {
            Ok((materials, _)) => {
                for m in materials {
                    by_name.insert(m.name.clone(), list.len());
                    list.push(m);
                }
            }
            Err(e) => notes.warnings.push(format!("material library {name:?} is not valid: {e}")),
        }
    }
    for name in missing {
        notes
            .warnings
            .push(format!("material library {name:?} cannot be read; its materials are taken as opaque"));
    }
    for name in &tidied.materials {
        if !by_name.contains_key(name) {
            by_name.insert(name.clone(), list.len());
            list.push(tobj::Material { name: name.clone(), ..tobj::Material::default() });
        }
    }
    if list.iter().any(|m| m.dissolve_texture.is_some()) {
        notes.warnings.push("opacity maps (map_d) are ignored".to_owned());
    }
    (list, by_name)
}

/// Dissolve below 1 is treated as glTF's BLEND: it casts where it is at least 0.5.
fn material(m: &tobj::Material, options: &LoadOptions) -> Material {
    let [r, g, b] = m.diffuse.unwrap_or([0.8; 3]);
    let dissolve = m.dissolve.filter(|d| d.is_finite()).unwrap_or(1.0);
    let blended = dissolve < 1.0;
    let alpha =
        if blended && !options.ignore_alpha { AlphaMode::Mask { cutoff: 0.5 } } else { AlphaMode::Opaque };
    Material { alpha, blended, ..Material::opaque(&m.name, [r, g, b, dissolve]) }
}

fn load_textures(
    path: &Path,
    library: &[tobj::Material],
    used: &[bool],
    materials: &mut [Material],
    scene: &mut Scene,
) {
    let mut known: HashMap<&str, Option<u32>> = HashMap::new();
    for ((json, material), _) in library.iter().zip(materials).zip(used).filter(|&(_, &used)| used) {
        let Some(file) = json.diffuse_texture.as_deref() else { continue };
        let texture = *known.entry(file).or_insert_with(|| {
            let ending = file.rsplit_once('.').map_or("", |(_, ending)| ending);
            let decoded = std::fs::read(beside(path, file))
                .map_err(|e| e.to_string())
                .and_then(|bytes| Texture::decode(file.to_owned(), &bytes, ending, false));
            match decoded {
                Ok(mut texture) => {
                    make_opaque(&mut texture);
                    scene.textures.push(texture);
                    Some(scene.textures.len() as u32 - 1)
                }
                Err(what) => {
                    let name = &material.name;
                    scene
                        .notes
                        .warnings
                        .push(format!("material {name:?} loses its colour texture {file}: {what}"));
                    None
                }
            }
        });
        material.texture = texture;
    }
}

/// map_Kd is colour alone; opacity must not depend on whether colours were asked for.
fn make_opaque(texture: &mut Texture) {
    if let Pixels::Rgba(bytes) = &mut texture.pixels {
        for texel in bytes.chunks_exact_mut(4) {
            texel[3] = 255;
        }
    }
}

/// A file named in the scene, which may have been written on Windows.
fn beside(scene: &Path, name: &str) -> std::path::PathBuf {
    scene.parent().unwrap_or(Path::new("")).join(name.replace('\\', "/"))
}
