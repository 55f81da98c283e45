//! Options that every verb of `tree` shares with those of `adumbra`, and trees in `render`.

use std::fs;
use std::process::Command;

use adumbra_testing::{Folder, lab, lab_json, lab_program, stderr};
use serde_json::json;

#[test]
fn every_tree_verb_accepts_threads_memory_and_json() {
    let folder = Folder::new();
    let (scene, file, picture) = (folder.generate("city"), folder.path("a.adumtree"), folder.path("a.png"));
    let (texture, back) = (folder.path("t.png"), folder.path("b.adumtree"));
    let (points, answers) = (folder.write_f32("p.f32", &[0.0, 500.0, 0.0]), folder.path("v.f32"));
    let verify = ["tree", "verify", &file, "--scene", &scene, "--samples", "10000", "--min-interior", "0"];
    let calls: &[(&[&str], &str)] = &[
        (&["tree", "bake", &scene, "--resolution", "256", "-o", &file], "file_bytes"),
        (&verify, "agreement"),
        (&["tree", "query", &file, "--points", &points, "-o", &answers], "points"),
        (&["tree", "export", &file, "--texture", &texture], "words"),
        (&["tree", "import", &texture, "-o", &back], "words"),
        (&["render", &scene, "--shadow-file", &file, "--size", "32x32", "-o", &picture], "width"),
    ];
    for (call, field) in calls {
        let said = lab_json(&[*call, &["--threads", "2", "--max-memory", "2GiB", "--json"]].concat());
        assert!(said[field].is_number(), "{call:?}: {said}");
    }
    assert_eq!(fs::read(&file).unwrap(), fs::read(&back).unwrap());
    for (call, _) in calls {
        let (code, error) = lab(&[*call, &["--max-memory", "1KiB"]].concat());
        assert_eq!(code, 4, "{call:?}: {error}");
        let (code, error) = lab(&[*call, &["--threads", "0"]].concat());
        assert_eq!(code, 2, "{call:?}: {error}");
    }
}

#[test]
fn render_bakes_tree_on_demand() {
    let folder = Folder::new();
    let (scene, file) = (folder.generate("primitives"), folder.path("a.adumtree"));
    let draw = |more: &[&str], name: &str| {
        let picture = folder.path(name);
        let base = ["render", &scene, "--shadow", "voxel-cubes", "--size", "96x64", "-o", &picture];
        let (code, error) = lab(&[&base[..], more].concat());
        assert_eq!(code, 0, "{error}");
        (error, fs::read(&picture).unwrap())
    };
    let (said, on_demand) = draw(&["--cube-resolution", "256"], "on-the-way.png");
    let note = "note: no world-aligned --shadow-file; baking one with 256 voxels per side";
    assert!(said.contains(note), "{said}");
    let (code, error) = lab(&["tree", "bake", &scene, "--resolution", "256", "-o", &file]);
    assert_eq!(code, 0, "{error}");
    let (said, given) = draw(&["--shadow-file", &file], "given.png");
    assert!(!said.contains("baking"), "{said}");
    assert!(on_demand == given, "another picture of a file that is baked on the way");
    let picture = folder.path("none.png");
    let cubes = ["render", &scene, "--shadow", "voxel-cubes", "--size", "32x32", "-o", &picture];
    let (code, error) = lab(&[&cubes[..], &["--cube-resolution", "1000"]].concat());
    assert_eq!(code, 2, "{error}");
    assert!(error.contains("not a power of two") && !folder.exists("none.png"), "{error}");
}

#[test]
fn render_shows_voxel_size_of_tree() {
    let folder = Folder::new();
    let (scene, file) = (folder.generate("primitives"), folder.path("a.adumtree"));
    let baked = lab_json(&["tree", "bake", &scene, "--resolution", "256", "-o", &file, "--json"]);
    let picture = folder.path("a.png");
    let render = ["render", &scene, "--shadow-file", &file, "--layer", "voxel-size", "--size", "96x64"];
    let said = lab_json(&[&render[..], &["--json", "-o", &picture]].concat());
    let rows = said["voxel_levels"].as_array().unwrap();
    assert!(rows.len() > 1, "{said}");
    let edge = |row: &serde_json::Value| row["edge_world"].as_f64().unwrap();
    for row in rows {
        let voxel = baked["voxel_size"].as_f64().unwrap() * row["level"].as_f64().unwrap().exp2();
        assert!((edge(row) / voxel - 1.0).abs() < 1e-9 && row["share"].as_f64().unwrap() > 0.0, "{row}");
    }
    let output =
        Command::new(lab_program()).args([&render[..], &["-o", &picture]].concat()).output().unwrap();
    let legend = String::from_utf8(output.stdout).unwrap();
    let line = format!("level {}: {:.4} world units, ", rows[0]["level"], edge(&rows[0]));
    assert!(legend.contains(&line), "{line} is not in {legend}");
}

/// A triangle under a light that looks straight down.
const LIT: &str = r#"{
  "asset": {"version": "2.0"},
  "extensionsUsed": ["KHR_lights_punctual"],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}},
  "scenes": [{"nodes": [0, 1]}],
  "nodes": [
    {"mesh": 0},
    {"name": "Noon", "rotation": [-0.7071067811865476, 0, 0, 0.7071067811865476],
     "extensions": {"KHR_lights_punctual": {"light": 0}}}
  ],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}],
  "buffers": [{"byteLength": 36, "uri": "triangle.bin"}]
}"#;

#[test]
fn tree_sun_defaults_to_light_of_scene() {
    let folder = Folder::new();
    folder.write_f32("triangle.bin", &[0.0, 0.0, 0.0, 0.0, 0.0, 8.0, 8.0, 0.0, 0.0]);
    let scene = folder.write("lit.gltf", LIT.as_bytes());
    let file = folder.path("a.adumtree");
    for (option, origin, sun, text) in [
        (
            &[][..],
            json!({"source": "light", "light": "Noon"}),
            [0.0, 1.0, 0.0],
            "(light \"Noon\" of the scene)",
        ),
        (
            &["--sun", "0,3,4"],
            json!({"source": "option", "light": null}),
            [0.0, 0.6, 0.8],
            "sun 0,3,4 (--sun)",
        ),
    ] {
        let bake = ["tree", "bake", &scene, "--resolution", "64", "--progress", "none", "-o", &file];
        let bake = [&bake[..], option].concat();
        let said = lab_json(&[&bake[..], &["--json"]].concat());
        assert_eq!(said["sun_origin"], origin);
        for (axis, expected) in sun.iter().enumerate() {
            assert!((said["sun"][axis].as_f64().unwrap() - expected).abs() < 1e-6, "{said}");
        }
        assert_eq!(lab_json(&["tree", "info", &file, "--json"])["sun"], said["sun"]);
        let output = Command::new(lab_program()).args(&bake).output().unwrap();
        let printed = String::from_utf8(output.stdout.clone()).unwrap();
        assert!(printed.contains(text), "{printed} {}", stderr(&output));
    }
    let (picture, render) = (folder.path("a.png"), ["render", &scene, "--shadow-file", &file, "--json"]);
    let said = lab_json(&[&render[..], &["--size", "16x16", "--device", "cpu", "-o", &picture]].concat());
    assert_eq!(said["sun_origin"]["source"], "shadow-file");
}
