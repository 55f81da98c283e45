//! `bench bake` and `bench verify` as users run them, on a small scene.

use std::fs;

use adumbra_testing::{Folder, lab};
use serde_json::{Value, json};

#[test]
#[ignore = "slow: a whole benchmark"]
fn bench_bake_and_verify_write_tables() {
    let folder = Folder::new();
    folder.generate("primitives");
    let out = folder.path("bench");
    let scenes = folder.path("");
    let arguments = [
        "bench",
        "bake",
        "--scenes",
        &scenes,
        "--names",
        "primitives.glb",
        "--resolutions",
        "128,256",
        "--variant-resolution",
        "128",
        "-o",
        &out,
    ];
    assert_eq!(lab(&arguments).0, 0);
    let table = fs::read_to_string(folder.path("bench/bake.md")).unwrap();
    assert!(table.contains("| primitives.glb | 256 |") && table.contains("static receivers"), "{table}");
    let document: Value = serde_json::from_slice(&fs::read(folder.path("bench/bake.json")).unwrap()).unwrap();
    assert_eq!(document["resolutions"].as_array().unwrap().len(), 2);
    let arguments = [
        "bench",
        "verify",
        "--scenes",
        &scenes,
        "--names",
        "primitives.glb",
        "--resolution",
        "1024",
        "--samples",
        "20000",
        "-o",
        &out,
    ];
    let (code, error) = lab(&arguments);
    assert_eq!(code, 0, "{error}");
    assert!(fs::read_to_string(folder.path("bench/verify.md")).unwrap().contains("elevation 3°"));
}

#[test]
fn bench_bake_reads_outside_files_only_if_allowed() {
    let folder = Folder::new();
    fs::create_dir(folder.path("sub")).unwrap();
    let scene = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"uri": "../secret.bin", "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    });
    folder.write("sub/outside.gltf", scene.to_string().as_bytes());
    folder.write_f32("secret.bin", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let (scenes, out) = (folder.path("sub"), folder.path("tables"));
    let bench = [
        "bench",
        "bake",
        "--scenes",
        &scenes,
        "--names",
        "outside.gltf",
        "--resolutions",
        "64",
        "--variant-resolution",
        "64",
        "-o",
        &out,
    ];
    let (code, message) = lab(&bench);
    assert_eq!(code, 3, "{message}");
    assert!(message.contains("../secret.bin") && message.contains("--allow-outside"), "{message}");
    let (code, message) = lab(&[&bench[..], &["--allow-outside"]].concat());
    assert_eq!(code, 0, "{message}");
}
