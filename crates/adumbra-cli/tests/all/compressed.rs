//! Real scenes, compressed by real encoders: Draco's, meshoptimizer's and gltfpack.
//!
//! Where the encoding keeps every value, in whatever order, the shadow file has the same bytes as that of the
//! scene as it was. Otherwise the file is verified against the compressed scene's own geometry.
//!
//! Needs Node.js and the encoders in `xtask/encoders`, which `cargo xtask test` installs. Without them the
//! test prints a note and passes, unless `ADUMBRA_REQUIRE_TOOLS` is set, as `cargo xtask test` does.
//! `ADUMBRA_FULL=1` tries every method on every scene, at a higher resolution, and prints a table.

use std::path::{Path, PathBuf};
use std::process::Command;

use adumbra_testing::{Folder, adumbra, full, json, shared, stderr};

const SCENES: [&str; 11] = [
    "alpine-2",
    "box-city-5k",
    "bridge_garden",
    "delft",
    "dream_apartment",
    "jacksboro",
    "kaykit_city_21",
    "oak_medium",
    "pine_medium",
    "street-1",
    "zdm2",
];
const LOSSLESS: [&str; 3] = ["draco-lossless", "draco-lossless-edgebreaker", "meshopt"];
const OTHERS: [&str; 5] = ["draco", "draco-speed0", "meshopt-quantized", "gltfpack", "gltfpack-cc"];

#[test]
#[ignore = "slow: real scenes"]
fn shared_scenes_in_compressed_forms() {
    let (Some(scenes), Some(encoder)) = (shared("scenes"), encoder()) else { return };
    for (index, name) in SCENES.iter().step_by(if full() { 1 } else { 3 }).enumerate() {
        let scene = scenes.join(format!("{name}.glb"));
        let folder = Folder::new();
        let original = bake(&folder, "original", &scene.display().to_string());
        for method in methods(&LOSSLESS, index) {
            let packed = encode(&encoder, method, &scene, &folder);
            let file = bake(&folder, method, &packed);
            let same = std::fs::read(&file).unwrap() == std::fs::read(&original).unwrap();
            assert!(same, "{name}, {method}: another shadow file");
            report(name, method, &scene, &packed, "same bytes");
        }
        for method in methods(&OTHERS, index) {
            let packed = encode(&encoder, method, &scene, &folder);
            let file = bake(&folder, method, &packed);
            let samples = if full() { "1000000" } else { "200000" };
            let verified = json(&["verify", &file, "--scene", &packed, "--samples", samples, "--json"]);
            let same = std::fs::read(&file).unwrap() == std::fs::read(&original).unwrap();
            let agreement = verified["interior_agreement"].as_f64().expect("an agreement");
            let bytes = if same { ", same bytes" } else { "" };
            let outcome = format!("interior agreement {:.4} %{bytes}", 100.0 * agreement);
            report(name, method, &scene, &packed, &outcome);
        }
    }
}

/// All methods of a list for a full run; otherwise one, another for each scene.
fn methods(list: &[&'static str], scene: usize) -> Vec<&'static str> {
    if full() { list.to_vec() } else { vec![list[scene % list.len()]] }
}

/// Prints a row of the table of docs/figures.md.
fn report(name: &str, method: &str, scene: &Path, packed: &str, outcome: &str) {
    let size = |path: &Path| std::fs::metadata(path).unwrap().len() as f64 / 1e6;
    println!("| {name} | {method} | {:.2} | {:.2} | {outcome} |", size(scene), size(Path::new(packed)));
}

/// Bakes a scene. `verify` ends with 1, and [`json`] fails, if a promise is missed.
fn bake(folder: &Folder, name: &str, scene: &str) -> String {
    let file = folder.path(&format!("{name}.adumbra"));
    let resolution = if full() { "8192" } else { "2048" };
    let (code, message) = adumbra(&[
        "bake",
        scene,
        "-o",
        &file,
        "--sun",
        "0.5,0.8,0.35",
        "--resolution",
        resolution,
        "--progress",
        "none",
    ]);
    assert_eq!(code, 0, "{scene}: {message}");
    file
}

fn encode(encoder: &Path, method: &str, scene: &Path, folder: &Folder) -> String {
    let packed = folder.path(&format!("{method}.glb"));
    let encoded = Command::new("node").arg(encoder).arg(method).arg(scene).arg(&packed).output().unwrap();
    assert!(encoded.status.success(), "{method}: {}", stderr(&encoded));
    packed
}

/// The script that compresses; `None` if it cannot run.
fn encoder() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../xtask/encoders");
    let runs = Command::new("node").arg("--version").output().is_ok_and(|o| o.status.success());
    if runs && folder.join("node_modules").is_dir() {
        return Some(folder.join("encode.js"));
    }
    let reason = "Node.js or xtask/encoders/node_modules is absent; run npm ci in xtask/encoders";
    adumbra_testing::left_out(reason, "ADUMBRA_REQUIRE_TOOLS");
    None
}
