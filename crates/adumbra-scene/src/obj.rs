//! Loads Wavefront OBJ with its MTL: one mesh per name of an object or group, with polygons triangulated.
//!
//! Sources: Wavefront's *Advanced Visualizer* manual, appendix B1 "Object files (.obj)", with the superseded
//! statements, and its MTL text. Departures: keywords may be in any case; faces may precede their vertices
//! and `usemtl` its `mtllib`; objects and groups are treated alike, and the most recent name counts; normals,
//! colours and smoothing are not read; curves and surfaces are counted, not read.
//!
//! The text is read twice, because faces may precede the vertices and names that they use: [`survey`] reads
//! the vertices and the names, then [`faces`] reads the faces. [`materials`] reads the libraries between the
//! two, and [`masks`] reads the textures afterwards. Positions are read in double precision, and geometry far
//! from zero is offset by its instances.

mod faces;
mod files;
mod maps;
mod masks;
mod materials;
mod room;
mod survey;
mod text;

use std::path::Path;

use crate::far_origin::placed_at;
use crate::sources::Sources;
use crate::validate::finish;
use crate::{EmptyReason, Error, Instance, LoadOptions, Result, Scene};

use faces::ObjMeshes;
use files::Files;
use masks::Textures;
use materials::Library;
use survey::Survey;

/// Loads a `.obj` file.
pub(super) fn load(path: &Path, options: &LoadOptions) -> Result<Scene> {
    let sources = Sources::new(path, "OBJ", options);
    let budget = &sources.budget;
    let text = text::decoded(sources.read_scene()?, budget)?.map_err(|what| sources.bad(what))?;
    // Joining continued lines makes copies.
    let copied = 2 * text.len() as u64;
    budget.charge(copied, || "the text".to_owned())?;
    let survey = Survey::of(&sources, &text)?;
    let mut scene = Scene::default();
    let files = Files::new(&sources);
    let library = Library::read(&files, &survey.libraries, &survey.materials, &mut scene.notes)?;
    let needs_uvs =
        options.color_textures || library.list.iter().any(|mtl| mtl.wanted_mask(options).is_some());
    let uvs = match needs_uvs {
        true => survey::texture_coordinates(&sources, &text, survey.uvs)?,
        false => Vec::new(),
    };
    let built = faces::read(&sources, &text, &survey, &uvs, &library, options)?;
    room::free(budget, uvs);
    budget.release(copied + text.len() as u64);
    drop(text);

    survey.report(&mut scene.notes);
    library.report(&built.used, options, &mut scene.notes);
    report(&built, &mut scene);
    let mut materials = library.materials(options);
    scene.textures =
        Textures::new(&files, options).load(&library, &built.used, &mut materials, &mut scene.notes)?;
    let world_from_mesh = placed_at(survey.offset);
    scene.instances = (0_u32..)
        .zip(&built.meshes)
        .map(|(mesh, m)| Instance { name: m.name.clone(), mesh, world_from_mesh, casts: true })
        .collect();
    (scene.meshes, scene.materials) = (built.meshes, materials);
    scene.notes.named_files = sources.named_files();
    finish(path, scene, &built.sieve, options).map_err(|e| explained(e, &survey, built.read.faces))
}

/// Records the counts of faces and of problems with them.
fn report(built: &ObjMeshes, scene: &mut Scene) {
    let notes = &mut scene.notes;
    notes.read = built.read;
    notes.untriangulated_polygons = built.untriangulated;
    notes.omit("faces with fewer than three corners", built.small);
    if built.unplaced > 0 {
        notes.warnings.push(format!(
            "{} faces have a material with an opacity map and no texture coordinates; they take those of its corner",
            built.unplaced
        ));
    }
}

/// Changes the error if a file without faces holds only points.
fn explained(error: Error, survey: &Survey, faces: u64) -> Error {
    let has_points = survey.points > 0 || !survey.positions.is_empty();
    match error {
        Error::NoTriangles { path, reason: EmptyReason::NoneStored | EmptyReason::OnlyOmitted { .. } }
            if faces == 0 && has_points && survey.lines + survey.curves == 0 =>
        {
            Error::NoTriangles { path, reason: EmptyReason::PointCloud }
        }
        error => error,
    }
}
