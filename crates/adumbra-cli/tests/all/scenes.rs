//! Untrusted scenes in the program: exit codes, messages, options.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use adumbra_testing::{Folder, adumbra, glb, json, program};

const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0];
const FACE: &str = "v 0 0 0\nv 0 0 1\nv 1 0 0\nf 1 2 3\n";

fn gltf(uri: &str) -> Vec<u8> {
    let json = json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "buffers": [{"uri": uri, "byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    });
    json.to_string().into_bytes()
}

/// Returns a folder with a triangle in `secret.bin` and an empty folder `sub`.
fn folder_with_a_secret() -> Folder {
    let folder = Folder::new();
    folder.write_f32("secret.bin", &TRIANGLE);
    std::fs::create_dir(folder.path("sub")).unwrap();
    folder
}

#[test]
fn hostile_scenes_end_soon_with_the_right_exit_codes() {
    let folder = folder_with_a_secret();
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uint int vertex_indices\nend_header\n";
    let ply = |count: u32, corners: [i32; 3]| {
        let mut out = header.as_bytes().to_vec();
        out.extend(TRIANGLE.iter().flat_map(|c| c.to_le_bytes()));
        out.extend(count.to_le_bytes());
        out.extend(corners.iter().flat_map(|c| c.to_le_bytes()));
        out
    };
    let secret = folder.path("secret.bin");
    let lines = |line: &str| (0..60_000).map(|i| line.replace('#', &i.to_string())).collect::<String>();
    let cases: [(&str, Vec<u8>, i32, &str); 11] = [
        ("biglist.ply", ply(u32::MAX, [0, 1, 2]), 3, "face 0"),
        ("ok.ply", ply(3, [0, 2, 1]), 0, ""),
        ("devzero.gltf", gltf("/dev/zero"), 3, "--allow-outside"),
        ("stdin.gltf", gltf("/dev/stdin"), 3, "--allow-outside"),
        ("sub/trav.gltf", gltf("../secret.bin"), 3, "--allow-outside"),
        ("sub/abs.gltf", gltf(&secret), 3, "--allow-outside"),
        ("sub/http.gltf", gltf("http://example.com/x.bin"), 3, "cannot read"),
        ("mtl.obj", format!("mtllib /dev/zero\n{FACE}").into_bytes(), 3, "--allow-outside"),
        ("slash.obj", format!("{FACE}{}", "\\\n".repeat(200_000)).into_bytes(), 0, ""),
        ("mats.obj", format!("{FACE}{}", lines("usemtl m#\nf 1 2 3\n")).into_bytes(), 0, ""),
        ("groups.obj", format!("{FACE}{}", lines("o m#\nf 1 2 3\n")).into_bytes(), 0, ""),
    ];
    for (name, bytes, code, part) in cases {
        let scene = folder.write(name, &bytes);
        // A program that waited for a pipe, a device or a server would never end.
        let (said, message) = adumbra(&["inspect", &scene]);
        assert_eq!(said, code, "{name}: {message}");
        assert!(message.contains(part), "{name}: {message}");
    }
}

#[test]
fn every_verb_reads_outside_files_only_with_allow_outside() {
    let folder = folder_with_a_secret();
    let scene = folder.write("sub/trav.gltf", &gltf("../secret.bin"));
    let (file, picture) = (folder.path("t.adumbra"), folder.path("t.png"));
    let verbs: [&[&str]; 4] = [
        &["inspect", &scene],
        &["bake", &scene, "-o", &file, "--resolution", "64", "--sun", "0,1,0", "--progress", "none"],
        &["verify", &file, "--scene", &scene, "--samples", "1000", "--min-interior", "0"],
        &["render", &scene, "--truth", "--device", "cpu", "--size", "16x16", "-o", &picture],
    ];
    for verb in verbs {
        let (code, message) = adumbra(&[verb, &["--allow-outside"]].concat());
        assert_eq!(code, 0, "{verb:?}: {message}");
        let (code, message) = adumbra(verb);
        assert_eq!(code, 3, "{verb:?}: {message}");
        let parts = ["trav.gltf", "buffer 0", "../secret.bin", "--allow-outside"];
        assert!(parts.iter().all(|part| message.contains(part)), "{verb:?}: {message}");
    }
    for verb in ["compare", "view"] {
        let help = Command::new(program()).args([verb, "--help"]).output().unwrap();
        assert!(String::from_utf8_lossy(&help.stdout).contains("--allow-outside"), "{verb}");
    }
}

#[cfg(unix)]
#[test]
fn rejects_a_pipe_as_scene() {
    let folder = Folder::new();
    for ending in ["glb", "gltf", "obj", "ply"] {
        let pipe = folder.path(&format!("pipe.{ending}"));
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let (code, message) = adumbra(&["inspect", &pipe]);
        assert_eq!(code, 3, "{message}");
        assert!(message.contains("not a regular file"), "{message}");
    }
}

/// Returns a GLB with `entries` image entries that all refer to one transparent image. Each masks a triangle
/// of its own.
fn bomb(entries: usize, side: u32) -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayAlphaImage::new(side, side).write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = png.into_inner();
    let floats = TRIANGLE.iter().chain(&[0.0, 0.0, 0.0, 1.0, 1.0, 0.0]);
    let bin: Vec<u8> = floats.flat_map(|c| c.to_le_bytes()).chain(png.iter().copied()).collect();
    let each = |of: fn(usize) -> Value| (0..entries).map(of).collect::<Vec<_>>();
    let json = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": each(|i| json!({"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": i}))}],
        "materials": each(|i| json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorTexture": {"index": i}}})),
        "textures": each(|i| json!({"source": i})),
        "images": each(|_| json!({"bufferView": 2, "mimeType": "image/png"})),
        "buffers": [{"byteLength": bin.len()}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 24},
            {"buffer": 0, "byteOffset": 60, "byteLength": png.len()},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
    });
    glb(&json, &bin)
}

#[test]
fn a_scene_beyond_the_memory_allowed_exits_with_4() {
    let folder = Folder::new();
    let scene = folder.write("bomb.glb", &bomb(200, 4_000));
    let (file, picture) = (folder.path("b.adumbra"), folder.path("b.png"));
    // Decoded once, the image takes 48 MB for a moment and 16 MB afterwards. Decoded per entry it would take
    // 3.2 GB.
    let verbs: [&[&str]; 3] = [
        &["inspect", &scene],
        &["bake", &scene, "--resolution", "64", "--progress", "none", "-o", &file],
        &["verify", &file, "--scene", &scene, "--samples", "1000", "--min-interior", "0"],
    ];
    for verb in verbs {
        let (code, message) = adumbra(&[verb, &["--max-memory", "200MiB", "--threads", "1"]].concat());
        assert_eq!(code, 0, "{verb:?}: {message}");
        let (code, message) = adumbra(&[verb, &["--max-memory", "40MiB", "--threads", "1"]].concat());
        assert_eq!(code, 4, "{verb:?}: {message}");
        let parts = ["bomb.glb", "4000 x 4000", "--max-memory"];
        assert!(parts.iter().all(|part| message.contains(part)), "{verb:?}: {message}");
    }
    let render = ["render", &scene, "--truth", "--device", "cpu", "--size", "16x16", "-o", &picture];
    let (code, message) = adumbra(&[&render[..], &["--max-memory", "40MiB", "--threads", "1"]].concat());
    assert_eq!(code, 4, "{message}");
    assert!(!Path::new(&picture).exists());
}

#[test]
fn polygons_that_cross_themselves_are_counted_in_a_warning() {
    let folder = Folder::new();
    let bow_tie = "v 0 0 0\nv 4 0 4\nv 4 0 0\nv 0 0 4\nf 1 2 3 4\n";
    let scene = folder.write("bow.obj", bow_tie.as_bytes());
    let (code, message) = adumbra(&["inspect", &scene]);
    assert_eq!(code, 0, "{message}");
    assert!(message.contains("1 polygons could not be triangulated properly"), "{message}");
    assert_eq!(json(&["inspect", &scene, "--json"])["untriangulated_polygons"], 1);
    let square = folder.write("square.obj", b"v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nf 1 2 3 4\n");
    assert_eq!(json(&["inspect", &square, "--json"])["untriangulated_polygons"], 0);
}
