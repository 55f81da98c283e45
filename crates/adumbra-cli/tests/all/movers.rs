//! Animated instances through the program: skipped by a bake unless asked for, and verified as they were
//! baked.

#![cfg(feature = "render")]

use adumbra_testing::{Folder, adumbra, glb, json};

/// Returns a GLB with a ground and a block above it that rises, from 1 m at the first key to 9 m at the
/// second.
fn rising_block() -> Vec<u8> {
    let mut bin = Vec::new();
    let mut floats = |values: &[f32]| {
        let from = bin.len();
        bin.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        (from, values.len() * 4)
    };
    let square = |half: f32| {
        let corner = |x: f32, z: f32| [x * half, 0.0, z * half];
        [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)]
            .into_iter()
            .chain([corner(-1.0, -1.0), corner(1.0, 1.0), corner(1.0, -1.0)])
            .flatten()
            .collect::<Vec<f32>>()
    };
    let parts = [
        (floats(&square(10.0)), 6, "VEC3"),
        (floats(&square(2.0)), 6, "VEC3"),
        (floats(&[0.0, 1.0]), 2, "SCALAR"),
        (floats(&[0.0, 1.0, 0.0, 0.0, 9.0, 0.0]), 2, "VEC3"),
    ];
    let views: Vec<_> = parts
        .iter()
        .map(|((o, l), _, _)| serde_json::json!({"buffer": 0, "byteOffset": o, "byteLength": l}))
        .collect();
    let accessors: Vec<_> = (0..)
        .zip(&parts)
        .map(|(i, (_, n, t))| serde_json::json!({"bufferView": i, "componentType": 5126, "count": n, "type": t}))
        .collect();
    let document = serde_json::json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "name": "ground"}, {"mesh": 1, "name": "lift"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}, {"primitives": [{"attributes": {"POSITION": 1}}]}],
        "animations": [{"samplers": [{"input": 2, "output": 3}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}]}],
        "buffers": [{"byteLength": bin.len()}], "bufferViews": views, "accessors": accessors,
    });
    glb(&document, &bin)
}

#[test]
fn bake_leaves_movers_out_and_verify_agrees() {
    let folder = Folder::new();
    let scene = folder.write("lift.glb", &rising_block());
    let bake = |name: &str, more: &[&str]| {
        let file = folder.path(name);
        let words = [&["bake", &scene, "--resolution", "512", "-o", &file], more].concat();
        let (code, said) = adumbra(&words);
        assert_eq!(code, 0, "{said}");
        (file, said)
    };
    let (without, said) = bake("without.adumbra", &[]);
    assert!(said.contains("1 animated instances are skipped"), "{said}");
    let (with, said) = bake("with.adumbra", &["--include-animated"]);
    assert!(!said.contains("are skipped"), "{said}");
    let verify = |file: &str, more: &[&str]| {
        let words = [&["verify", file, "--scene", &scene, "--samples", "20000", "--json"], more].concat();
        json(&words)["shadowed_share"].as_f64().unwrap()
    };
    assert_eq!(verify(&without, &[]), 0.0);
    // In its first pose the block is 1 m above the ground, and its shadow falls onto the ground.
    assert!(verify(&with, &["--include-animated"]) > 0.02);
}

#[test]
fn render_numbers_frames_and_rejects_unmoving_scenes() {
    let folder = Folder::new();
    let scene = folder.generate("city");
    let lift = folder.write("lift.glb", &rising_block());
    let draw = |words: &[&str]| {
        let always = ["--device", "cpu", "--truth", "--size", "32x18", "--antialias", "1"];
        adumbra(&[&["render"], words, &always].concat())
    };
    let (code, said) = draw(&[&scene, "--move", "sphere", "--frames", "2", "-o", &folder.path("ball.png")]);
    assert_eq!(code, 0, "{said}");
    assert!(folder.exists("ball.0000.png") && folder.exists("ball.0001.png") && !folder.exists("ball.png"));
    // The animation's first and last pictures differ. Frozen in the first pose they do not.
    let picture = |name: &str, more: &[&str]| {
        let output = folder.path(name);
        let (code, said) = draw(&[&[lift.as_str(), "-o", &output], more].concat());
        assert_eq!(code, 0, "{said}");
        std::fs::read(output).unwrap()
    };
    let view = ["--eye", "0,12,14", "--target", "0,1,0"];
    let at =
        |seconds: &str, more: &[&str]| picture("lift.png", &[&["--time", seconds], &view[..], more].concat());
    assert_ne!(at("0", &[]), at("1", &[]));
    assert_eq!(at("0", &["--include-animated"]), at("1", &["--include-animated"]));
    let (code, said) = draw(&[&scene, "--frames", "2", "-o", &folder.path("still.png")]);
    assert!(code == 2 && said.contains("nothing moves"), "{code} {said}");
    let (code, said) = draw(&[&scene, "--move", "cube", "-o", &folder.path("still.png")]);
    assert!(code == 2 && said.contains("the only one is sphere"), "{code} {said}");
}
