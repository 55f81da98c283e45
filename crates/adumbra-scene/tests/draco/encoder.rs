//! A generated scene, compressed by `gltf-transform` (npm: `@gltf-transform/cli`) under every method and
//! speed. Skipped with a message if that program is neither on the path nor named by
//! `ADUMBRA_GLTF_TRANSFORM`.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};

use adumbra_scene::{GeneratedKind, LoadOptions, Scene, generate, load, write_glb};

use crate::fixture::{assert_close, triangles};

/// The encoder, if it runs.
fn encoder() -> Option<OsString> {
    let program = std::env::var_os("ADUMBRA_GLTF_TRANSFORM").unwrap_or_else(|| "gltf-transform".into());
    let version =
        Command::new(&program).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if version.is_ok_and(|status| status.success()) {
        return Some(program);
    }
    eprintln!(
        "skipped: no gltf-transform; npm install @gltf-transform/cli, and set ADUMBRA_GLTF_TRANSFORM to it"
    );
    None
}

fn compress(program: &OsString, from: &Path, to: &Path, method: &str, speed: &str, bits: &str) -> Scene {
    let mut command = Command::new(program);
    command.arg("draco").args([from, to]).args(["--method", method, "--encode-speed", speed]);
    for attribute in ["position", "normal", "texcoord", "color", "generic"] {
        command.args([&format!("--quantize-{attribute}"), bits]);
    }
    let done = command.args(["--decode-speed", speed]).output().expect("runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    load(to, &LoadOptions::default()).expect("loads")
}

#[test]
fn draco_files_of_gltf_transform_equal_the_scene() {
    let Some(program) = encoder() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let [from, to] = ["plain.glb", "compressed.glb"].map(|name| folder.path().join(name));
    write_glb(&generate(GeneratedKind::Cornell, 1), &from).expect("writes");
    let plain = load(&from, &LoadOptions::default()).expect("loads");
    for method in ["edgebreaker", "sequential"] {
        for speed in ["0", "3", "5", "10"] {
            // With 0 bits, floats are not quantized.
            let lossless = compress(&program, &from, &to, method, speed, "0");
            assert!(triangles(&lossless) == triangles(&plain), "{method} {speed}");
            let quantized = compress(&program, &from, &to, method, speed, "14");
            assert_close(&plain, &quantized, 5.6 / 16383.0, 0.0);
        }
    }
}
