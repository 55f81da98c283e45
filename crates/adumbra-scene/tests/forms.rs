//! A property of the loaders: a generated scene gives the same triangles in whichever form it is written.
//!
//! Coordinates are multiples of 1/4 and small, so that every form can hold them exactly, and triangles are
//! compared bit for bit in world space.

#[path = "forms/gltf.rs"]
mod gltf;
#[path = "forms/model.rs"]
mod model;
#[path = "forms/obj.rs"]
mod obj;
#[path = "forms/ply.rs"]
mod ply;

use std::path::Path;

use adumbra_scene::{LoadOptions, Scene, load};
use model::{Model, World, canonical};

/// The seeds of the models.
const SEEDS: std::ops::Range<u64> = 0..40;

/// A form: its name, the name of its main file, and the files that it consists of.
type Form = (&'static str, &'static str, fn(&Model) -> Vec<(String, Vec<u8>)>);

#[test]
fn every_form_of_a_scene_gives_the_same_triangles() {
    let forms = [obj::FORMS, ply::FORMS, gltf::FORMS].concat();
    for seed in SEEDS {
        let model = Model::new(seed);
        let expected = model.world();
        for (name, file, write) in &forms {
            let folder = tempfile::tempdir().expect("a temporary folder");
            for (part, bytes) in write(&model) {
                std::fs::write(folder.path().join(part), bytes).expect("writes");
            }
            let scene =
                read(&folder.path().join(file)).unwrap_or_else(|e| panic!("{name}, seed {seed}: {e}"));
            let found = World { triangles: triangles(&scene), flat: flat(&scene) };
            assert!(found == expected, "{name}, seed {seed}: other triangles");
        }
    }
}

/// Loads a scene; any omission is an error.
fn read(path: &Path) -> adumbra_scene::Result<Scene> {
    load(path, &LoadOptions { strict: true, ..LoadOptions::default() })
}

fn triangles(scene: &Scene) -> Vec<[[u64; 3]; 3]> {
    let placed = scene.instances.iter().flat_map(|instance| {
        let mesh = &scene.meshes[instance.mesh as usize];
        mesh.triangles.iter().map(|t| t.map(|i| instance.to_world(mesh.positions[i as usize])))
    });
    canonical(placed)
}

/// Whether the scene has triangles without area.
fn flat(scene: &Scene) -> bool {
    scene.notes.degenerate_triangles > 0
}
