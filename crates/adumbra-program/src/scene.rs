//! Loading a scene, with its warnings.

use std::path::Path;

use adumbra_scene as scene;
use adumbra_scene::{LoadOptions, Scene};

use schemars::JsonSchema;
use serde::Serialize;

use crate::exit::Failure;
use crate::memory::MemoryLimit;
use crate::output::note_scene;

/// A kind of thing that a scene's file holds and the loader leaves out.
#[derive(Serialize, JsonSchema)]
pub struct Omitted {
    /// What was left out, as a plural.
    pub what: String,
    /// How many there are.
    pub count: u64,
}

/// Returns what the loader left out, each kind once.
pub fn omitted(scene: &Scene) -> Vec<Omitted> {
    let of = |o: &adumbra_scene::Omission| Omitted { what: o.what.clone(), count: o.count };
    scene.notes.omissions.iter().map(of).collect()
}

/// Loads a scene and prints the loader's warnings on stderr.
///
/// # Errors
///
/// Returns [`Failure::Scene`] if the scene, or a file that it names, cannot be read.
pub fn load_scene(path: &Path, options: &LoadOptions) -> Result<Scene, Failure> {
    load_scene_within(MemoryLimit::new(None), path, options)
}

/// Loads a scene within a memory limit, and prints the loader's warnings on stderr.
///
/// # Errors
///
/// Returns [`Failure::Scene`] if the scene, or a file that it names, cannot be read, and [`Failure::Scene`]
/// or [`Failure::Bake`] if that takes more memory than allowed.
pub fn load_scene_within(limit: MemoryLimit, path: &Path, options: &LoadOptions) -> Result<Scene, Failure> {
    let share = limit.share(0);
    let options = LoadOptions { max_memory_bytes: share.bytes(), ..options.clone() };
    let scene = scene::load(path, &options).map_err(|error| share.whole(error.into()))?;
    limit.check_peak("loading the scene")?;
    let notes = &scene.notes;
    note_scene(path, notes);
    for warning in &notes.warnings {
        crate::note!("warning: {}: {warning}", path.display());
    }
    for omission in &notes.omissions {
        crate::note!("warning: {}: {omission} left out; --strict makes this an error", path.display());
    }
    for pattern in &notes.unmatched_patterns {
        let option = if pattern.excludes { "--exclude" } else { "--only" };
        crate::note!("warning: {}: {option} {pattern}", path.display());
    }
    if notes.looks_z_up {
        crate::note!(
            "warning: {}: flat along Z, or much taller than wide, as a scene is in which Z points up; if so, give --up z, and --up y if not",
            path.display()
        );
    }
    if notes.outside_textures > 0 {
        crate::note!(
            "note: {}: files outside the scene's folder are read only with --allow-outside; use it for scenes that you trust",
            path.display()
        );
    }
    if notes.degenerate_triangles > 0 {
        crate::note!(
            "warning: {}: {} degenerate triangles skipped",
            path.display(),
            notes.degenerate_triangles
        );
    }
    if notes.untriangulated_polygons > 0 {
        crate::note!(
            "warning: {}: {} polygons could not be triangulated properly: they intersect themselves, are far from flat or have more than 16384 corners; triangulate them in the \
            program that made them",
            path.display(),
            notes.untriangulated_polygons
        );
    }
    if notes.blended_materials > 0 {
        crate::note!(
            "note: {}: {} blended materials cast shadows where alpha >= 0.5",
            path.display(),
            notes.blended_materials
        );
    }
    if notes.skipped_movers > 0 {
        crate::note!(
            "note: {}: {} animated instances are skipped because they move; --include-animated loads them in their first pose",
            path.display(),
            notes.skipped_movers
        );
    }
    Ok(scene)
}
