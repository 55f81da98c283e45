//! Loads Wavefront OBJ with its MTL: one mesh per object or group name, with polygons triangulated.
//!
//! `tobj` groups faces, cuts fans and reads materials. First, [`tidy`] rewrites the file to the part of the format that
//! `tobj` handles reliably, triangulates the polygons that a fan would not cover, and reports invalid lines by number.
//! Positions are read in double precision, and geometry far from zero is offset by its instances.

mod tidy;

use std::collections::{HashMap, HashSet};
use std::path::Path;

use crate::far_origin::placed_at;
use crate::sources::{Located, MAX_IMAGE_BYTES, MAX_LIBRARY_BYTES, OUTSIDE, Sources};
use crate::validate::{Sieve, check_vertex, finish};
use crate::{
    AlphaMode, Error, Instance, LoadNotes, LoadOptions, Material, Mesh, Pixels, Result, Scene, Texture,
};

/// Materials as `tobj` returns them: a list, and the index of each name in it.
type Library = (Vec<tobj::Material>, HashMap<String, usize>);

/// Loads a `.obj` file.
pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let sources = Sources::new(path, "OBJ", options);
    let bytes = sources.read_scene()?;
    let length = bytes.len() as u64;
    sources.budget.charge(2 * length, || "the text".to_owned())?;
    let mut tidied = tidy::object(&sources, &bytes, options.color_textures)?;
    drop(bytes);
    let passing = charge(&sources, &tidied, 3 * length)?;
    let mut scene = Scene::default();
    scene.notes.omit("lines, points and faces with fewer than three corners", tidied.skipped);
    scene.notes.untriangulated_polygons = tidied.untriangulated;
    let library = read_libraries(&sources, &tidied, &mut scene.notes)?;
    let loading = tobj::LoadOptions { single_index: true, triangulate: true, ..tobj::LoadOptions::default() };
    let (models, _) = tobj::load_obj_buf(&mut &tidied.text[..], &loading, |_| Ok(library.clone()))
        .map_err(|e| Error::SceneParse { path: path.to_owned(), format: "OBJ", what: e.to_string() })?;
    let names = std::mem::take(&mut tidied.names);
    let world_from_mesh = placed_at(tidied.offset);
    drop(tidied);

    let mut materials: Vec<Material> = library.0.iter().map(|m| material(m, options)).collect();
    materials.push(Material::opaque("default", [0.8, 0.8, 0.8, 1.0]));
    let mut sieve = Sieve::default();
    let mut by_name: HashMap<usize, usize> = HashMap::new();
    let mut used = vec![false; materials.len()];
    for model in models {
        let material = model.mesh.material_id.unwrap_or(library.0.len());
        // Faces that precede any name belong to the unnamed object, which has index 0.
        let number = model.name.parse().unwrap_or(0);
        let (Some(named), Some(name)) = (materials.get(material), names.get(number)) else { continue };
        if !options.filter.keeps(name, name, &named.name) {
            sieve.filtered = true;
            continue;
        }
        if let Some(used) = used.get_mut(material) {
            *used = true;
        }
        let next = scene.meshes.len();
        let index = *by_name.entry(number).or_insert(next);
        if index == next {
            scene.meshes.push(Mesh { name: name.clone(), ..Mesh::default() });
        }
        if let Some(mesh) = scene.meshes.get_mut(index) {
            append(path, mesh, &model.mesh, material as u32, options.color_textures, &mut sieve)?;
        }
    }
    sources.budget.release(passing);
    if options.color_textures {
        load_textures(&sources, &library.0, &used, &mut materials, &mut scene)?;
    }
    scene.instances = (0_u32..)
        .zip(&scene.meshes)
        .map(|(mesh, m)| Instance { name: m.name.clone(), mesh, world_from_mesh, casts: true })
        .collect();
    scene.materials = materials;
    scene.notes.named_files = sources.named_files();
    finish(path, scene, &sieve, options)
}

/// Appends the triangles of one model to `mesh`.
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
        // The OBJ texture origin is at the bottom left.
        let (uvs, _) = model.texcoords.as_chunks::<2>();
        mesh.uvs.extend(uvs.iter().map(|&[u, v]| [u, 1.0 - v].map(|c| if c.is_finite() { c } else { 0.0 })));
        mesh.uvs.resize(mesh.positions.len(), [0.0; 2]);
    }
    Ok(())
}

/// Bytes per triangle held by the parser until its mesh is built.
const PARSED_TRIANGLE_BYTES: u64 = 120;
/// Bytes per vertex held by the parser until its mesh is built.
const PARSED_VERTEX_BYTES: u64 = 48;
/// Bytes per model held by the parser until its mesh is built, without triangles and vertices.
const PARSED_MODEL_BYTES: u64 = size_of::<tobj::Model>() as u64;
/// Bytes per triangle in the scene.
const TRIANGLE_BYTES: u64 = 16;
/// Bytes per vertex in the scene.
const VERTEX_BYTES: u64 = 20;
/// Bytes per material, both parsed and in the scene.
const MATERIAL_BYTES: u64 = 1024;

/// Releases `before` bytes and charges the memory that parsing is about to need. Returns the bytes that can be released
/// once the meshes are built.
fn charge(sources: &Sources<'_>, tidied: &tidy::Object, before: u64) -> Result<u64> {
    sources.budget.release(before);
    let passing = tidied.text.len() as u64
        + tidied.triangles * PARSED_TRIANGLE_BYTES
        + tidied.vertices * PARSED_VERTEX_BYTES
        + tidied.models * PARSED_MODEL_BYTES;
    let kept = tidied.triangles * TRIANGLE_BYTES + tidied.vertices * VERTEX_BYTES;
    let materials = tidied.materials.len() as u64 * MATERIAL_BYTES;
    sources.budget.charge(passing + kept + materials, || {
        format!("{} triangles and {} vertices", tidied.triangles, tidied.vertices)
    })?;
    Ok(passing)
}

/// Reads every MTL file, and adds an opaque material for each name that is missing from all of them.
///
/// # Errors
/// Returns [`Error::OutsideScene`], [`Error::NotRegularFile`] or [`Error::SceneMemory`]. Missing or invalid libraries
/// become warnings.
fn read_libraries(sources: &Sources<'_>, tidied: &tidy::Object, notes: &mut LoadNotes) -> Result<Library> {
    let (mut list, mut by_name): Library = Default::default();
    let mut missing = Vec::new();
    let mut known = HashSet::new();
    for name in &tidied.libraries {
        let read = match locate(sources, tidy::LIBRARY, name) {
            Ok(file) if !known.insert(file.clone()) => continue,
            Ok(file) => sources.read_whole(&file, tidy::LIBRARY, MAX_LIBRARY_BYTES),
            Err(e) => Err(e),
        };
        let bytes = match read {
            Ok(bytes) => bytes,
            Err(Error::Io(_)) => {
                missing.push(name);
                continue;
            }
            Err(e) => return Err(e),
        };
        tidy::named(&bytes, |name| note_named(sources, name))?;
        let text = tidy::materials(&bytes);
        let count = text.split(|&b| b == b'\n').filter(|line| line.starts_with(b"newmtl")).count() as u64;
        sources.budget.charge(count * MATERIAL_BYTES, || format!("{count} materials of {name:?}"))?;
        match tobj::load_mtl_buf(&mut &text[..]) {
            Ok((materials, _)) => {
                for m in materials {
                    by_name.insert(m.name.clone(), list.len());
                    list.push(m);
                }
            }
            Err(e) => notes.warnings.push(format!("material library {name:?} is not valid: {e}")),
        }
        sources.budget.release(bytes.len() as u64);
    }
    for name in missing {
        notes
            .warnings
            .push(format!("material library {name:?} cannot be read; its materials are treated as opaque"));
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
    Ok((list, by_name))
}

/// Converts a material. Dissolve below 1 is treated like glTF's BLEND: it casts if it is at least 0.5.
fn material(m: &tobj::Material, options: &LoadOptions) -> Material {
    let [r, g, b] = m.diffuse.unwrap_or([0.8; 3]);
    let dissolve = m.dissolve.filter(|d| d.is_finite()).unwrap_or(1.0);
    let blended = dissolve < 1.0;
    let alpha =
        if blended && !options.ignore_alpha { AlphaMode::Mask { cutoff: 0.5 } } else { AlphaMode::Opaque };
    Material { alpha, blended, ..Material::opaque(&m.name, [r, g, b, dissolve]) }
}

/// Loads the colour textures of the materials that are used. Textures that cannot be read become warnings.
///
/// # Errors
/// Returns [`Error::SceneMemory`] if the textures exceed the memory budget.
fn load_textures(
    sources: &Sources<'_>,
    library: &[tobj::Material],
    used: &[bool],
    materials: &mut [Material],
    scene: &mut Scene,
) -> Result<()> {
    let mut named: HashMap<&str, Option<u32>> = HashMap::new();
    let mut decoded: HashMap<Located, Option<u32>> = HashMap::new();
    for ((parsed, material), _) in library.iter().zip(materials).zip(used).filter(|&(_, &used)| used) {
        let Some(file) = parsed.diffuse_texture.as_deref() else { continue };
        if let Some(&known) = named.get(file) {
            material.texture = known;
            continue;
        }
        let place = format!("map_Kd of material {:?}", material.name);
        let texture = match locate(sources, &place, file) {
            Ok(located) => match decoded.get(&located) {
                Some(&known) => Ok(known),
                None => decode(sources, &located, &place, file)?.map(|texture| {
                    scene.textures.push(texture);
                    let index = Some(scene.textures.len() as u32 - 1);
                    decoded.insert(located, index);
                    index
                }),
            },
            Err(Error::OutsideScene { .. }) => {
                scene.notes.outside_textures += 1;
                Err(OUTSIDE.to_owned())
            }
            Err(e) => Err(e.to_string()),
        };
        material.texture = texture.unwrap_or_else(|what| {
            let warning =
                format!("material {:?}: the colour texture {file} is ignored: {what}", material.name);
            scene.notes.warnings.push(warning);
            None
        });
        named.insert(file, material.texture);
    }
    Ok(())
}

/// Decodes a colour texture. The inner error is a clause for a message.
fn decode(
    sources: &Sources<'_>,
    file: &Located,
    place: &str,
    named: &str,
) -> Result<Result<Texture, String>> {
    let bytes = match sources.read_whole(file, place, MAX_IMAGE_BYTES) {
        Ok(bytes) => bytes,
        Err(e @ Error::SceneMemory { .. }) => return Err(e),
        Err(e) => return Ok(Err(e.to_string())),
    };
    let ending = named.rsplit_once('.').map_or("", |(_, ending)| ending);
    let decoded = Texture::decode(named.to_owned(), &bytes, ending, false, &sources.budget)?;
    sources.budget.release(bytes.len() as u64);
    Ok(decoded.map(|mut texture| {
        make_opaque(&mut texture);
        texture
    }))
}

/// Makes a map_Kd texture opaque: it is colour only, and opacity must not depend on whether colours are loaded.
fn make_opaque(texture: &mut Texture) {
    if let Pixels::Rgba(bytes) = &mut texture.pixels {
        for texel in bytes.chunks_exact_mut(4) {
            texel[3] = 255;
        }
    }
}

/// Records a file that the scene references, in the form in which [`locate`] looks it up.
fn note_named(sources: &Sources<'_>, named: &str) -> Result<()> {
    sources.note_named(&named.replace('\\', "/"))
}

/// Finds a file that the scene references. Backslashes become slashes, since the scene may have been written on
/// Windows.
fn locate(sources: &Sources<'_>, place: &str, named: &str) -> Result<Located> {
    sources.locate(place, &named.replace('\\', "/"))
}
